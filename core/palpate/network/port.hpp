// The energy that one port has taken and given since the start.
#pragma once

#include <algorithm>

#include "palpate/types/spatial.hpp"

namespace palpate::network {

/// Work of a force on a measured position, taken and given apart. Their difference is the exact sum of F . dx. For what
/// is taken, the position passes through a backlash of kBacklash: a measurement that flickers under load would
/// otherwise add to both for ever. A sum of what is given with a backlash of its own would miss the largest force of
/// each stroke.
class Port {
 public:
  /// One tick: F acts on the hand or on the tool [N] during the motion to x [m].
  void step(const Vec3& F, const Vec3& x) noexcept {
    if (!started_) x_ = last_ = x;
    started_ = true;
    net_ -= F.dot(x - last_);
    last_ = x;
    const Vec3 away = x - x_;
    const double distance = away.norm();
    if (!(distance > kBacklash)) return;
    const Vec3 dx = away * ((distance - kBacklash) / distance);
    x_ += dx;
    in_ += std::max(-F.dot(dx), 0.0);
  }
  /// What moves it until the next tick is no work of the force, e.g. others who carry the tool.
  void carried() noexcept { started_ = false; }
  /// The part of a force at this velocity [m/s] by which the port gives no more than the other one has taken [J].
  [[nodiscard]] Vec3 affordable(const Vec3& F, const Vec3& v, double taken, double dt) const noexcept {
    const double cost = std::max(F.dot(v) + 0.5 * F.norm() * kAcceleration * dt, 0.0) * dt;
    const double room = kAdvance + taken - out();
    return cost > 0.0 ? Vec3(std::clamp(room / cost, 0.0, 1.0) * F) : F;
  }
  [[nodiscard]] double in() const noexcept { return in_; }
  [[nodiscard]] double out() const noexcept { return in_ - net_; }
  [[nodiscard]] double net() const noexcept { return net_; }

 private:
  static constexpr double kBacklash = 2e-5;      ///< [m]
  static constexpr double kAdvance = 1e-4;       ///< given before the other port has taken any [J]
  static constexpr double kAcceleration = 5.0;   ///< within a tick [m/s^2]
  Vec3 x_ = Vec3::Zero(), last_ = Vec3::Zero();  ///< behind the backlash, and before it
  double in_ = 0.0, net_ = 0.0;
  bool started_ = false;
};

}  // namespace palpate::network
