// Rotations and their logarithm.
#pragma once

#include <Eigen/Geometry>

#include "palpate/types/spatial.hpp"

namespace palpate {

/// The logarithm of a rotation: its axis times its angle, 0 to pi [rad].
[[nodiscard]] inline Vec3 rotation_vector(const Mat3& R) noexcept {
  const Eigen::AngleAxisd rotation(R);
  return rotation.angle() * rotation.axis();
}

}  // namespace palpate
