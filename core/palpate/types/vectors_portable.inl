// Lanes, the portable counterpart of the vectors of AVX2. Included by the portable kernels alone, each inside its own
// namespace.

/// Vector of N numbers with element-wise operators.
template <class T, int N>
struct Lanes {
  T x[N];
  static Lanes all(T s) {
    Lanes r;
    for (T& e : r.x) e = s;
    return r;
  }
  static Lanes load(const T* s) {
    Lanes r;
    for (int i = 0; i < N; ++i) r.x[i] = s[i];
    return r;
  }
  void store(T* s) const {
    for (int i = 0; i < N; ++i) s[i] = x[i];
  }
};

template <class T, int N, class Op>
Lanes<T, N> lanes(const Lanes<T, N>& a, const Lanes<T, N>& b, Op op) {
  Lanes<T, N> r;
  for (int i = 0; i < N; ++i) r.x[i] = op(a.x[i], b.x[i]);
  return r;
}
template <class T, int N>
Lanes<T, N> operator+(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return lanes(a, b, [](T x, T y) { return x + y; });
}
template <class T, int N>
Lanes<T, N> operator-(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return lanes(a, b, [](T x, T y) { return x - y; });
}
template <class T, int N>
Lanes<T, N> operator*(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return lanes(a, b, [](T x, T y) { return x * y; });
}
template <class T, int N>
Lanes<T, N> max(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return lanes(a, b, [](T x, T y) { return x > y ? x : y; });
}
