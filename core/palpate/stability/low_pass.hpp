// A first-order low-pass of the wanted wrench.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::stability {

/// Options of the low-pass.
struct LowPassOptions {
  double cutoff = 0.0;  ///< cutoff frequency [Hz]; 0: no filter
};

/// y_k = y_k-1 + a (u_k - y_k-1),   a = low_pass_coefficient(cutoff, dt)
///
/// The filter delays a ramp by dt (1 - a) / a, close to 1 / (2 pi cutoff).
class LowPass {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  LowPass(const LowPassOptions& options, double dt);
  /// One tick: the filtered wrench.
  Wrench step(const Wrench& F) noexcept;
  void reset() noexcept { y_ = {}; }
  [[nodiscard]] double lag() const noexcept { return lag_; }  ///< lag of a ramp [s]

 private:
  double gain_ = 1.0, lag_ = 0.0;
  Wrench y_;
};

}  // namespace palpate::stability
