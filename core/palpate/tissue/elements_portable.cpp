// The portable kernels: the same computations on plain arrays.
#include <cmath>
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

F8 root(const F8& a) {
  return lanes(a, a, [](float x, float) { return std::sqrt(x); });
}

struct Rows {
  F8 x[3];
};
Rows load_rows(const float* u, const std::uint32_t row[kWide]) {
  Rows out;
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < kWide; ++i) out.x[c].x[i] = u[row[i] + c];
  return out;
}

void differences(const float* u, const std::uint32_t row[kWide], const Rows& from, F8 out[3]) {
  const Rows rows = load_rows(u, row);
  for (int c = 0; c < 3; ++c) out[c] = rows.x[c] - from.x[c];
}

void add_to_rows(const F8 x[3], const std::uint32_t row[kWide], float* to) {
  for (int i = 0; i < kWide; ++i)
    for (int c = 0; c < 3; ++c) to[row[i] + c] += x[c].x[i];
}

#include "palpate/tissue/elements.inl"

void forces(const ElementList& list, NodeArrays& nodes) noexcept { forces_in(list, nodes); }

}  // namespace
}  // namespace portable

Kernel portable_kernel() noexcept { return &portable::forces; }

}  // namespace palpate::tissue
