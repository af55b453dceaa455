// Stage `stability` on one axis: the same step() as in the haptic cycle, for tests with a simulated Axis.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "palpate/stability/stability.hpp"
#include "palpate/verify/axis.hpp"

namespace palpate::verify {

/// Gives the stage the inputs that a device has: the measured position, and its mean velocity over the last period, or
/// over the last four if the position is quantised.
class AxisLayer : public AxisStage {
 public:
  /// options.passivity.friction: of one joint, or empty.
  AxisLayer(const stability::Options& options, const AxisOptions& axis)
      : stage_(options, 1.0 / axis.rate),
        bilateral_(axis.bilateral),
        window_(options.passivity.observer.quantum > 0.0 ? kWindow : 1) {
    in_.stiffness = axis.K;
    in_.handle.q = JointVector::Zero(1);
    in_.handle.valid = in_.tool.valid = true;
  }

  double step(double F, double x, double dt) noexcept override {
    if (steps_ == 0) x_.fill(x);
    const std::size_t window = std::clamp<std::size_t>(steps_, 1, window_);
    in_.handle.V_LH.v.x() =
        (x - x_[(steps_ - std::min(steps_, window)) % kWindow]) / (static_cast<double>(window) * dt);
    x_[steps_++ % kWindow] = x;
    in_.commanded.F.f.x() = F;
    in_.handle.X_LH.p.x() = in_.handle.q[0] = x;
    in_.potential = bilateral_ || x > 0.0 ? 0.5 * in_.stiffness * x * x : 0.0;
    const stability::Output out = stage_.step(in_);
    stage_.rendered(out.F_H_L);
    acted_ = acted_ || out.F_passivity.f.x() != 0.0;
    return out.F_H_L.f.x();
  }
  /// True if the passivity controller has withheld force.
  [[nodiscard]] bool acted() const noexcept { return acted_; }
  [[nodiscard]] const stability::PassivityController& passivity() const noexcept { return stage_.passivity(); }

 private:
  static constexpr std::size_t kWindow = 4;

  stability::Stability stage_;
  stability::Input in_;
  bool bilateral_;
  std::size_t window_;
  std::array<double, kWindow> x_{};
  std::size_t steps_ = 0;
  bool acted_ = false;
};

}  // namespace palpate::verify
