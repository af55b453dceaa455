// A first-order low-pass of the wanted wrench.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::stability {

struct LowPassOptions {
  double cutoff = 0.0;  ///< [Hz]; 0: none
};

/// y_k = y_k-1 + a (u_k - y_k-1),   a = low_pass_share(cutoff, dt)
///
/// A ramp comes out later by dt (1 - a) / a, close to 1 / (2 pi cutoff).
class LowPass {
 public:
  /// dt [s]. Throws std::invalid_argument.
  LowPass(const LowPassOptions& options, double dt);
  Wrench step(const Wrench& F) noexcept;
  void reset() noexcept { y_ = {}; }
  [[nodiscard]] double lag() const noexcept { return lag_; }  ///< of a ramp [s]

 private:
  double gain_ = 1.0, lag_ = 0.0;
  Wrench y_;
};

}  // namespace palpate::stability
