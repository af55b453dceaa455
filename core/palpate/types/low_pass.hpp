// Coefficient of the first-order low-pass filter that all stages use.
#pragma once

#include <cmath>
#include <numbers>

namespace palpate {

/// Coefficient a of the filter
///
///   y_k = y_k-1 + a (u_k - y_k-1),     a = 1 - exp(-2 pi cutoff dt)
///
/// which is exact for an input u that is constant over the period dt [s]. cutoff [Hz]; 0 switches
/// the filter off (a = 1).
[[nodiscard]] inline double low_pass_coefficient(double cutoff, double dt) noexcept {
  return cutoff > 0.0 ? -std::expm1(-2.0 * std::numbers::pi * cutoff * dt) : 1.0;
}

}  // namespace palpate
