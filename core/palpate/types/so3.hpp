// Logarithm of a rotation.
#pragma once

#include <Eigen/Geometry>

#include "palpate/types/spatial.hpp"

namespace palpate {

/// Rotation vector of R: the axis times the angle, with the angle between 0 and pi [rad].
[[nodiscard]] inline Vec3 rotation_vector(const Mat3& R) noexcept {
  const Eigen::AngleAxisd rotation(R);
  return rotation.angle() * rotation.axis();
}

}  // namespace palpate
