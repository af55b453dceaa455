// A position servo by its exact solution, shared by who simulates it and who reckons with it.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace palpate {

/// exp(A dt) of e' = v, v' = -w^2 e - 2 zeta w v, e = position minus goal. w [rad/s], dt [s].
[[nodiscard]] inline Eigen::Matrix2d servo_transition(double w, double zeta, double dt) noexcept {
  const double s = (zeta * zeta - 1.0) * w * w;  // squared half distance of the two poles
  const double root = std::sqrt(std::abs(s));
  // c and k: cosh and sinh / root of the pole distance, cos and sin / root when the poles are complex.
  const double x = root * dt;
  const double c = s > 0.0 ? std::cosh(x) : std::cos(x);
  const double k = x < 1e-6 ? dt : (s > 0.0 ? std::sinh(x) : std::sin(x)) / root;
  const double decay = std::exp(-zeta * w * dt);
  Eigen::Matrix2d phi;
  phi << c + zeta * w * k, k, -w * w * k, c - zeta * w * k;
  return decay * phi;
}

}  // namespace palpate
