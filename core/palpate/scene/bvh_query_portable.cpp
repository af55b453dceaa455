// The portable kernel: the same traversal on plain arrays. This file also selects the kernel, once.
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "palpate/scene/bvh.hpp"

#define PALPATE_TARGET

namespace palpate::scene {
namespace portable {
namespace {

#include "palpate/types/vectors_portable.inl"

template <class T, int N>
Lanes<T, N> operator/(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return lanes(a, b, [](T x, T y) { return x / y; });
}
// Comparisons return masks: lanes of one (true) and zero (false).
template <class T, int N>
Lanes<T, N> operator<(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return lanes(a, b, [](T x, T y) { return x < y ? T(1) : T(0); });
}
template <class T, int N>
Lanes<T, N> operator<=(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return lanes(a, b, [](T x, T y) { return x <= y ? T(1) : T(0); });
}
template <class T, int N>
Lanes<T, N> operator&(const Lanes<T, N>& a, const Lanes<T, N>& b) {
  return a * b;
}
template <class T, int N>
Lanes<T, N> select(const Lanes<T, N>& mask, const Lanes<T, N>& a, const Lanes<T, N>& b) {
  Lanes<T, N> r;
  for (int i = 0; i < N; ++i) r.x[i] = mask.x[i] != T(0) ? a.x[i] : b.x[i];
  return r;
}
/// A NaN becomes lo.
template <class T, int N>
Lanes<T, N> clamp(const Lanes<T, N>& a, const Lanes<T, N>& lo, const Lanes<T, N>& hi) {
  const Lanes<T, N> r = max(a, lo);
  return lanes(r, hi, [](T x, T y) { return x < y ? x : y; });
}
template <class T, int N>
unsigned mask_of(const Lanes<T, N>& a) {
  unsigned mask = 0;
  for (int i = 0; i < N; ++i) mask |= (a.x[i] != T(0) ? 1U : 0U) << i;
  return mask;
}

using F8 = Lanes<float, 8>;
using D4 = Lanes<double, 4>;

F8 root(const F8& a) {
  F8 r;
  for (int i = 0; i < 8; ++i) r.x[i] = std::sqrt(a.x[i]);
  return r;
}

D4 dot(const D4 a[3], const D4 b[3]) { return a[0] * b[0] + (a[1] * b[1] + a[2] * b[2]); }

#include "palpate/scene/bvh_query.inl"

}  // namespace
}  // namespace portable

BvhHit bvh_closest_portable(const Bvh& bvh, const double p[3], const BvhHit& best, double exact_within) noexcept {
  return portable::closest_in(bvh, p, best, exact_within);
}

namespace {
const auto kKernel = bvh_has_avx2() ? &bvh_closest_avx2 : &bvh_closest_portable;  // selected when the library is loaded
}  // namespace

BvhHit bvh_closest(const Bvh& bvh, const double p[3], const BvhHit& best, double exact_within) noexcept {
  return kKernel(bvh, p, best, exact_within);
}

}  // namespace palpate::scene
