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
F8 minus_product(const F8& a, const F8& b, const F8& c) { return a - b * c; }
F8 min(const F8& a, const F8& b) {
  return lanes(a, b, [](float x, float y) { return x < y ? x : y; });
}
F8 reciprocal(const F8& a) {
  return lanes(F8::all(1.0F), a, [](float x, float y) { return x / y; });
}

void gather(const float* u, const std::uint32_t row[4][kWide], F8 first[4], F8 other[3][4]) {
  for (int c = 0; c < 4; ++c)
    for (int i = 0; i < kWide; ++i) {
      first[c].x[i] = u[row[0][i] + c];
      for (int k = 0; k < 3; ++k) other[k][c].x[i] = u[row[k + 1][i] + c] - first[c].x[i];
    }
}

void scatter(const F8 f[3][3], const std::uint32_t row[4][kWide], float* force) {
  for (int i = 0; i < kWide; ++i)
    for (int c = 0; c < 3; ++c) {
      float sum = 0.0F;
      for (int k = 0; k < 3; ++k) {
        force[row[k + 1][i] + c] -= f[k][c].x[i];
        sum += f[k][c].x[i];
      }
      force[row[0][i] + c] += sum;
    }
}

#include "palpate/tissue/elements.inl"

void dilatation(ElementArrays& a) noexcept { dilatation_in(a); }
void forces(ElementArrays& a) noexcept { forces_in(a); }

}  // namespace
}  // namespace portable

Kernel portable_kernel() noexcept { return {&portable::dilatation, &portable::forces}; }

}  // namespace palpate::tissue
