// Exact solution of a second-order position servo, used to simulate servos and to predict their motion.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace palpate {

/// Transition matrix exp(A dt) of the state (e, v), where e' = v, v' = -w^2 e - 2 zeta w v, and e = position - goal.
/// The servo has the natural frequency w [rad/s] and the damping ratio zeta [-]; dt is the time step [s].
[[nodiscard]] inline Eigen::Matrix2d servo_transition(double w, double zeta, double dt) noexcept {
  const double s = (zeta * zeta - 1.0) * w * w;  // squared half distance between the two poles [1/s^2]
  const double root = std::sqrt(std::abs(s));
  // Real poles: c = cosh(x), k = sinh(x) / root. Complex poles: c = cos(x), k = sin(x) / root.
  const double x = root * dt;
  const double c = s > 0.0 ? std::cosh(x) : std::cos(x);
  const double k = x < 1e-6 ? dt : (s > 0.0 ? std::sinh(x) : std::sin(x)) / root;
  const double decay = std::exp(-zeta * w * dt);
  Eigen::Matrix2d phi;
  phi << c + zeta * w * k, k, -w * w * k, c - zeta * w * k;
  return decay * phi;
}

}  // namespace palpate
