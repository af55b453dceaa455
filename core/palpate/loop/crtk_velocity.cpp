#include "palpate/loop/crtk_velocity.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/low_pass.hpp"
#include "palpate/types/so3.hpp"
#include "palpate/types/status.hpp"

namespace palpate::loop {
namespace {

constexpr double kPoseCutoff = 40.0;  // [Hz] of the low-pass for velocities differenced from poses
constexpr double kExcessFade = 0.1;   // [s] in which differences between both streams fade
constexpr double kTwistLag = 0.03;    // [s] by which a filtered twist may lag behind the poses
constexpr double kExcess = 1e-3;      // [m] difference of the displacements that noise and rounding explain
constexpr double kTurned = 0.02;      // [rad] the same for rotations

bool fits(const Twist& V, const WatchOptions& most) noexcept {
  return V.v.norm() <= 2.0 * most.v_max && V.w.norm() <= 2.0 * most.w_max;  // false for NaN
}

}  // namespace

void HandVelocity::moved(const Pose& from, const Pose& to, double dt, ClockTime now) noexcept {
  const Vec3 step = to.p - from.p, turn = rotation_vector(to.R * from.R.transpose());
  const double share = low_pass_coefficient(kPoseCutoff, dt);
  V_differenced_.v += share * (step / dt - V_differenced_.v);
  V_differenced_.w += share * (turn / dt - V_differenced_.w);
  if (speaks(now)) {
    compare(step, turn, dt);
  } else {
    p_excess_.setZero();
    R_excess_.setZero();
  }
}

void HandVelocity::reported(double stamp, const Twist& V, ClockTime now) noexcept {
  if (!twist_.stamp(stamp, now)) return;
  if (!(V.v.allFinite() && V.w.allFinite())) {
    twist_.refuse(kNotFinite);
  } else if (!fits(V, options_)) {
    twist_.refuse(kStreamsDisagree, V.v.norm(), V_differenced_.v.norm());
  } else {
    V_reported_ = V;
  }
}

// A delay T between the streams makes a difference of T times the speed; it fades as fast as the maximum of the speed.
void HandVelocity::compare(const Vec3& moved, const Vec3& turned, double dt) noexcept {
  const double fade = std::exp(-dt / kExcessFade), lag = kTwistLag + dt;
  v_most_ = std::max(V_differenced_.v.norm(), fade * v_most_);
  w_most_ = std::max(V_differenced_.w.norm(), fade * w_most_);
  p_excess_ = fade * (p_excess_ + V_reported_.v * dt - moved);
  R_excess_ = fade * (R_excess_ + V_reported_.w * dt - turned);
  if (p_excess_.norm() > kExcess + lag * v_most_ || R_excess_.norm() > kTurned + lag * w_most_) {
    twist_.refuse(kStreamsDisagree, V_reported_.v.norm(), V_differenced_.v.norm());
  }
}

}  // namespace palpate::loop
