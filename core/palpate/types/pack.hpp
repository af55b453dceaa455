// All lanes as two vectors of four numbers. Compilers do not always see that a loop over lanes is one vector operation;
// here it is spelt out. Without AVX2 the same operations are done two numbers at a time.
#pragma once

#include "palpate/types/lanes.hpp"

namespace palpate {

#define PALPATE_INLINE [[gnu::always_inline]] inline

using Four = double __attribute__((vector_size(4 * sizeof(double))));

struct Pack {
  Four low, high;
};
static_assert(sizeof(Pack) == sizeof(Lanes));

/// Four numbers anywhere in memory. (A memcpy would keep the packs in memory, too.)
using FourInMemory = double __attribute__((vector_size(4 * sizeof(double)), aligned(sizeof(double)), may_alias));

PALPATE_INLINE Pack load(const Lanes& x) noexcept {
  const auto* from = reinterpret_cast<const FourInMemory*>(x);
  return {from[0], from[1]};
}
PALPATE_INLINE void store(const Pack& p, Lanes& x) noexcept {
  auto* to = reinterpret_cast<FourInMemory*>(x);
  to[0] = p.low;
  to[1] = p.high;
}
PALPATE_INLINE Pack operator+(const Pack& a, const Pack& b) noexcept { return {a.low + b.low, a.high + b.high}; }
PALPATE_INLINE Pack operator-(const Pack& a, const Pack& b) noexcept { return {a.low - b.low, a.high - b.high}; }
PALPATE_INLINE Pack operator*(const Pack& a, const Pack& b) noexcept { return {a.low * b.low, a.high * b.high}; }
PALPATE_INLINE Pack operator/(const Pack& a, const Pack& b) noexcept { return {a.low / b.low, a.high / b.high}; }
PALPATE_INLINE Pack operator*(double a, const Pack& b) noexcept { return {a * b.low, a * b.high}; }
PALPATE_INLINE Pack operator-(const Pack& a) noexcept { return {-a.low, -a.high}; }
PALPATE_INLINE Pack constant(double a) noexcept { return {a + Four{}, a + Four{}}; }
/// The larger of the two; b if a is not a number.
PALPATE_INLINE Pack max(const Pack& a, const Pack& b) noexcept {
  return {a.low > b.low ? a.low : b.low, a.high > b.high ? a.high : b.high};
}
/// The smaller of the two; b if a is not a number.
PALPATE_INLINE Pack min(const Pack& a, const Pack& b) noexcept {
  return {a.low < b.low ? a.low : b.low, a.high < b.high ? a.high : b.high};
}
/// yes where a <= b, otherwise no.
PALPATE_INLINE Pack where_at_most(const Pack& a, const Pack& b, const Pack& yes, const Pack& no) noexcept {
  return {a.low <= b.low ? yes.low : no.low, a.high <= b.high ? yes.high : no.high};
}
/// x . y over all lanes.
PALPATE_INLINE double dot(const Pack& x, const Pack& y) noexcept {
  const Four s = x.low * y.low + x.high * y.high;
  return (s[0] + s[1]) + (s[2] + s[3]);
}
/// A x, where the columns of A are given.
PALPATE_INLINE Pack product(const Lanes (&columns)[kLanes], const Lanes& x) noexcept {
  Pack even = x[0] * load(columns[0]), odd = x[1] * load(columns[1]);  // two sums, so that the second need not wait
  for (int j = 2; j < kLanes; j += 2) {
    even = even + x[j] * load(columns[j]);
    odd = odd + x[j + 1] * load(columns[j + 1]);
  }
  return even + odd;
}

}  // namespace palpate
