// The energy that one port has taken and given since the start.
#pragma once

#include <cmath>

#include "palpate/types/spatial.hpp"

namespace palpate::network {

/// Work of a force on a measured position, taken and given apart. The position passes through a backlash of kBacklash:
/// a measurement that flickers under load would otherwise add to both sums for ever.
class Port {
 public:
  /// One tick: F acts on the hand or on the tool [N] during the motion to x [m]. Returns the work that went in [J].
  double step(const Vec3& F, const Vec3& x) noexcept {
    if (!started_) x_ = x;
    started_ = true;
    const Vec3 away = x - x_;
    const double distance = away.norm();
    if (!(distance > kBacklash)) return 0.0;
    const Vec3 dx = away * ((distance - kBacklash) / distance);
    x_ += dx;
    const double work = -F.dot(dx);
    (work > 0.0 ? in_ : out_) += std::abs(work);
    return work;
  }
  [[nodiscard]] double in() const noexcept { return in_; }
  [[nodiscard]] double out() const noexcept { return out_; }

 private:
  static constexpr double kBacklash = 2e-5;  ///< [m]
  Vec3 x_ = Vec3::Zero();
  double in_ = 0.0, out_ = 0.0;
  bool started_ = false;
};

}  // namespace palpate::network
