// The arc sine of small numbers.
#pragma once

namespace palpate {

inline constexpr double kSmallSine = 0.01;  ///< squares below which arc_sine_ratio() is exact to rounding

/// asin(x) / x for z = x^2 < kSmallSine. Taylor's series, whose next term is less than 1e-17.
inline double arc_sine_ratio(double z) noexcept {
  const double z2 = z * z;
  const double low = (1.0 + 1.0 / 6.0 * z) + (3.0 / 40.0 + 5.0 / 112.0 * z) * z2;
  const double high = (35.0 / 1152.0 + 63.0 / 2816.0 * z) + (231.0 / 13312.0 + 143.0 / 10240.0 * z) * z2;
  return low + high * (z2 * z2);
}

}  // namespace palpate
