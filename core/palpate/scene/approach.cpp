#include "palpate/scene/approach.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/types/so3.hpp"

namespace palpate::scene {
namespace {

constexpr double kSmooth = 4.0;     // rate of the velocity over k [-]
constexpr double kLever = 0.1;      // converts the limit of the acceleration to an angular acceleration [m]
constexpr double kMaxStep = 0.05;   // longest time moved in one step, when the loop was late [s]
constexpr double kMean = 0.2;       // time constant of the mean displacement [s]
constexpr double kNear = 3e-4;      // mean displacement within which an object rests [m]
constexpr double kNearTurn = 5e-3;  // the same of the rotation [rad]
constexpr double kSlow = 1e-3;      // speed below which an object may rest [m/s]
constexpr double kSlowTurn = 1e-2;  // the same of the rotation [rad/s]

Vec3 within(const Vec3& v, double most) noexcept {
  const double norm = v.norm();
  return norm > most ? Vec3(most / norm * v) : v;
}

/// Limits of a translation or of a rotation.
struct Limits {
  double speed, acceleration, gain;
};

/// Velocity after the time dt, from v and the displacement e to a target with the velocity v_target.
Vec3 next_velocity(const Vec3& v, const Vec3& e, const Vec3& v_target, const Limits& limits, double dt) noexcept {
  const double k = std::min(limits.gain, 0.5 / dt), left = e.norm();
  Vec3 wanted = v_target;
  if (left > 0.0) wanted += std::min(k * left, std::sqrt(limits.acceleration * left)) / left * e;
  const Vec3 change = (within(wanted, limits.speed) - v) * std::min(kSmooth * k * dt, 1.0);
  return v + within(change, limits.acceleration * dt);
}

bool slow(const Twist& V) noexcept { return V.v.norm() <= kSlow && V.w.norm() <= kSlowTurn; }

}  // namespace

void Approach::reset(Pose X_WO, double t) noexcept {  // a copy, because X_WO may be that of this object
  *this = Approach();
  X_WO_ = std::move(X_WO);
  t_ = t;
}

void Approach::step(const LiveTarget& target, const LiveOptions& options, double t) noexcept {
  const double dt = std::min(t - t_, kMaxStep);
  t_ = t;
  lost_ = target.lost || !(t - target.t <= options.max_age);
  if (!(dt > 0.0)) return;
  if (options.fade > 0.0) share_ = std::clamp(share_ + (lost_ ? -dt : dt) / options.fade, 0.0, 1.0);
  aim(target, options, dt);
  if (V_.v.isZero(0.0) && V_.w.isZero(0.0)) return;
  const Vec3 c = X_WO_ * options.p_OC + dt * V_.v;
  X_WO_.R = rotation_by(dt * V_.w) * X_WO_.R;
  X_WO_.p = c - X_WO_.R * options.p_OC;
}

// Chooses the velocity for the next dt.
void Approach::aim(const LiveTarget& target, const LiveOptions& options, double dt) noexcept {
  Vec3 e = Vec3::Zero(), turn = Vec3::Zero();
  Twist V;  // of the target's centre
  if (!lost_) {
    const double age = std::clamp(t_ - target.t, 0.0, options.max_age) - dt;  // X_WO_ is still that of the time t_ - dt
    const Vec3 arm = target.X_WO.R * options.p_OC;
    V = {target.V_WO.v + target.V_WO.w.cross(arm), target.V_WO.w};
    e = target.X_WO.p + arm + age * V.v - X_WO_ * options.p_OC;
    turn = rotation_vector(rotation_by(age * V.w) * target.X_WO.R * X_WO_.R.transpose());
  }
  const double share = std::min(dt / kMean, 1.0);
  off_ += share * (e - off_);
  turned_off_ += share * (turn - turned_off_);
  if (settled(V)) {
    V_ = {};
    return;
  }
  V_.v = next_velocity(V_.v, e, V.v, {options.speed, options.acceleration, options.gain}, dt);
  V_.w = next_velocity(V_.w, turn, V.w, {options.turn, options.acceleration / kLever, options.gain}, dt);
}

// True if the object may rest. An object that moves must come nearer to its target than one that rests already.
bool Approach::settled(const Twist& V_target) const noexcept {
  const double share = V_.v.isZero(0.0) && V_.w.isZero(0.0) ? 1.0 : 0.5;
  const bool near = off_.norm() < share * kNear && turned_off_.norm() < share * kNearTurn;
  return near && slow(V_) && slow(V_target);
}

}  // namespace palpate::scene
