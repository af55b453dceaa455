#include "palpate/scene/motion.hpp"

#include <cmath>
#include <numbers>

#include "palpate/types/so3.hpp"

namespace palpate::scene {
namespace {

/// Translation s and rotation vector theta at one time, and their rates.
struct State {
  Vec3 s, theta, s_dot, theta_dot;
};

State at(const Motion& m, double t) noexcept {
  const double dt = t - m.t0;
  State now{m.V.v * dt, m.V.w * dt, m.V.v, m.V.w};
  for (const Wave& wave : m.waves) {
    const double rate = 2.0 * std::numbers::pi / wave.period, angle = rate * dt + wave.phase;
    const double sine = std::sin(angle), slope = rate * std::cos(angle);
    now.s += sine * wave.shift;
    now.theta += sine * wave.rotation;
    now.s_dot += slope * wave.shift;
    now.theta_dot += slope * wave.rotation;
  }
  return now;
}

/// Angular velocity of the rotation R(theta) for a changing theta: the left Jacobian of SO(3) times theta_dot [rad/s].
Vec3 angular_velocity_of(const Vec3& theta, const Vec3& theta_dot) noexcept {
  const double a = theta.norm();
  // c1 = (1 - cos a) / a^2 and c2 = (a - sin a) / a^3, by their series near zero to avoid cancellation.
  const double c1 = a < 1e-3 ? 0.5 - a * a / 24.0 : (1.0 - std::cos(a)) / (a * a);
  const double c2 = a < 1e-3 ? 1.0 / 6.0 - a * a / 120.0 : (a - std::sin(a)) / (a * a * a);
  const Vec3 cross_product = theta.cross(theta_dot);
  return theta_dot + c1 * cross_product + c2 * theta.cross(cross_product);
}

}  // namespace

Pose Motion::pose(const Pose& X_WO, double t) const noexcept {
  if (is_static()) return X_WO;
  const State now = at(*this, t);
  const Mat3 R = rotation_by(now.theta);
  return {R * X_WO.R, R * (X_WO.p - about) + about + now.s};
}

Vec3 Motion::velocity(const Vec3& p, double t) const noexcept {
  if (is_static()) return Vec3::Zero();
  const State now = at(*this, t);
  return now.s_dot + angular_velocity_of(now.theta, now.theta_dot).cross(p - about - now.s);
}

Vec3 Motion::angular_velocity(double t) const noexcept {
  if (is_static()) return Vec3::Zero();
  const State now = at(*this, t);
  return angular_velocity_of(now.theta, now.theta_dot);
}

}  // namespace palpate::scene
