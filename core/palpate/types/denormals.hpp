// Denormal numbers as zero, within a scope. Arithmetic with them is up to a hundred times slower, and a vibration that
// decays leaves many of them.
#pragma once

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

namespace palpate {

/// While an object of this class lives, its thread treats denormal floating-point numbers as zero.
class [[maybe_unused]] DenormalsAreZero {
 public:
#if defined(__SSE2__)
  DenormalsAreZero() noexcept : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }  // flush results and operands
  ~DenormalsAreZero() { _mm_setcsr(before_); }
#else
  DenormalsAreZero() noexcept = default;
  ~DenormalsAreZero() = default;
#endif
  DenormalsAreZero(const DenormalsAreZero&) = delete;
  DenormalsAreZero& operator=(const DenormalsAreZero&) = delete;

#if defined(__SSE2__)
 private:
  unsigned before_;
#endif
};

}  // namespace palpate
