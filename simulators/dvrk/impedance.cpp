#include "dvrk/impedance.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/so3.hpp"

namespace palpate::dvrk {
namespace {

Vec3 half_planes(const HalfPlane& positive, const HalfPlane& negative, const Vec3& error, const Vec3& v) noexcept {
  Vec3 f;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const HalfPlane& side = error[k] > 0.0 ? positive : negative;
    const double beyond = std::max(std::abs(error[k]) - std::abs(side.deadband[k]), 0.0);
    f[k] = side.p[k] * std::copysign(beyond, error[k]) + side.d[k] * v[k] + side.bias[k];
  }
  return f;
}

}  // namespace

Wrench impedance_wrench(const Impedance& goal, const Pose& X, const Twist& V) noexcept {
  const Vec3 f = half_planes(goal.position_positive, goal.position_negative,
                             goal.R_force.transpose() * (X.p - goal.p_force), goal.R_force.transpose() * V.v);
  const Vec3 t = half_planes(goal.orientation_positive, goal.orientation_negative,
                             rotation_vector(goal.R_torque.transpose() * X.R), goal.R_torque.transpose() * V.w);
  return {goal.R_force * f, goal.R_torque * t};
}

}  // namespace palpate::dvrk
