// The portable kernels: the same computations on plain arrays. This file also selects the kernels, once.
#include <cstddef>
#include <cstdint>

#include "palpate/tissue/elements.hpp"

#define PALPATE_TARGET

namespace palpate::tissue {
namespace portable {
namespace {

struct F8 {
  float x[kWide];
  static F8 all(float s) {
    F8 r;
    for (float& e : r.x) e = s;
    return r;
  }
  static F8 load(const float* s) {
    F8 r;
    for (int i = 0; i < kWide; ++i) r.x[i] = s[i];
    return r;
  }
  void store(float* s) const {
    for (int i = 0; i < kWide; ++i) s[i] = x[i];
  }
};

template <class Op>
F8 lanes(const F8& a, const F8& b, Op op) {
  F8 r;
  for (int i = 0; i < kWide; ++i) r.x[i] = op(a.x[i], b.x[i]);
  return r;
}
F8 operator+(const F8& a, const F8& b) {
  return lanes(a, b, [](float x, float y) { return x + y; });
}
F8 operator-(const F8& a, const F8& b) {
  return lanes(a, b, [](float x, float y) { return x - y; });
}
F8 operator*(const F8& a, const F8& b) {
  return lanes(a, b, [](float x, float y) { return x * y; });
}
F8 mad(const F8& a, const F8& b, const F8& c) { return a * b + c; }
F8 negative(const F8& a) { return F8::all(0.0F) - a; }
F8 max(const F8& a, const F8& b) {
  return lanes(a, b, [](float x, float y) { return x > y ? x : y; });
}
F8 min(const F8& a, const F8& b) {
  return lanes(a, b, [](float x, float y) { return x < y ? x : y; });
}
F8 reciprocal(const F8& a) {
  return lanes(F8::all(1.0F), a, [](float x, float y) { return x / y; });
}

void gather(const float* u, const std::int32_t node[kWide], F8 out[3]) {
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < kWide; ++i) out[k].x[i] = u[4 * node[i] + k];
}

void scatter_add(const F8 f[3], const std::int32_t node[kWide], float* force) {
  for (int i = 0; i < kWide; ++i)
    for (int k = 0; k < 3; ++k) force[4 * node[i] + k] += f[k].x[i];
}

F8 mean_of_corners(const float* value, const std::int32_t node[4][kWide]) {
  F8 r = F8::all(0.0F);
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < kWide; ++i) r.x[i] += value[node[k][i]];
  return r * F8::all(0.25F);
}

#include "palpate/tissue/elements.inl"

void dilatation(ElementArrays& a) noexcept { dilatation_in(a); }
void forces(ElementArrays& a) noexcept { forces_in(a); }

}  // namespace
}  // namespace portable

Kernel portable_kernel() noexcept { return {&portable::dilatation, &portable::forces}; }

namespace {
const Kernel kKernel = has_avx2() ? avx2_kernel() : portable_kernel();  // selected when the library is loaded
}  // namespace

void add_dilatation(ElementArrays& a) noexcept { kKernel.add_dilatation(a); }
void add_forces(ElementArrays& a) noexcept { kKernel.add_forces(a); }

}  // namespace palpate::tissue
