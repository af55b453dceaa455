#include "palpate/stability/low_pass.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/types/low_pass.hpp"

namespace palpate::stability {

LowPass::LowPass(const LowPassOptions& options, double dt) {
  if (!(options.cutoff >= 0.0 && std::isfinite(options.cutoff))) {
    throw std::invalid_argument("stability.low_pass = " + std::to_string(options.cutoff) +
                                ": must be 0 Hz (none) or more, and finite; for example 100");
  }
  if (options.cutoff > 0.0) {
    gain_ = low_pass_coefficient(options.cutoff, dt);
    lag_ = dt * (1.0 - gain_) / gain_;
  }
}

Wrench LowPass::step(const Wrench& F) noexcept {
  if (gain_ == 1.0) return y_ = F;
  y_.f += gain_ * (F.f - y_.f);
  y_.t += gain_ * (F.t - y_.t);
  return y_;
}

}  // namespace palpate::stability
