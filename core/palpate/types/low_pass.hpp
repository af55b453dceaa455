// The first-order low-pass that all stages share.
#pragma once

#include <cmath>
#include <numbers>

namespace palpate {

/// a of  y_k = y_k-1 + a (u_k - y_k-1),  a = 1 - exp(-2 pi cutoff dt): exact for a u held over the period.
/// cutoff [Hz], 0: none, then a = 1; dt [s].
[[nodiscard]] inline double low_pass_share(double cutoff, double dt) noexcept {
  return cutoff > 0.0 ? -std::expm1(-2.0 * std::numbers::pi * cutoff * dt) : 1.0;
}

}  // namespace palpate
