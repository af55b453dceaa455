// The portable kernels: the same computations on plain arrays.
#include <cstddef>
#include <cstdint>

#include "palpate/tissue/elements.hpp"

#define PALPATE_TARGET

namespace palpate::tissue {
namespace portable {
namespace {

#include "palpate/types/vectors_portable.inl"

using F8 = Lanes<float, kWide>;

F8 mad(const F8& a, const F8& b, const F8& c) { return a * b + c; }
F8 negative(const F8& a) { return F8::all(0.0F) - a; }
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

}  // namespace palpate::tissue
