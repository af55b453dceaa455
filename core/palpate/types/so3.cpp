#include "palpate/types/so3.hpp"

#include <Eigen/Geometry>

namespace palpate {

Vec3 rotation_vector(const Mat3& R) noexcept {
  const Eigen::AngleAxisd rotation(R);
  return rotation.angle() * rotation.axis();
}

Mat3 rotation_by(const Vec3& theta) noexcept {
  const double angle = theta.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, theta / angle).toRotationMatrix() : Mat3::Identity();
}

}  // namespace palpate
