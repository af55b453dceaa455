#include "palpate/types/so3.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "palpate/types/arc_sine.hpp"

namespace palpate {

Vec3 rotation_vector(const Mat3& R) noexcept {
  // Half of R - R^T is the axis times the sine. A small angle needs a series only.
  const Vec3 s = 0.5 * Vec3(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  const double x = s.squaredNorm();
  if (x < kSmallSine && R(0, 0) + R(1, 1) + R(2, 2) > 1.0) return arc_sine_ratio(x) * s;
  const Eigen::AngleAxisd rotation = angle_axis(R);
  return rotation.angle() * rotation.axis();
}

Mat3 rotation_vector_derivative(const Vec3& phi) noexcept {
  const double angle2 = phi.squaredNorm(), angle = std::sqrt(angle2);
  const double k = angle < 1e-3 ? 1.0 / 12.0 : 1.0 / angle2 - 0.5 / angle / std::tan(0.5 * angle);
  Mat3 X;
  X << 0.0, -phi.z(), phi.y(), phi.z(), 0.0, -phi.x(), -phi.y(), phi.x(), 0.0;
  return Mat3::Identity() - 0.5 * X + k * X * X;
}

Eigen::AngleAxisd angle_axis(const Mat3& R) noexcept { return Eigen::AngleAxisd(R); }

Mat3 rotation_by(const Vec3& theta) noexcept {
  const double angle = theta.norm();
  return angle > 0.0 ? Eigen::AngleAxisd(angle, theta / angle).toRotationMatrix() : Mat3::Identity();
}

// As Eigen's FromTwoVectors, which takes a singular value decomposition for opposite vectors: most of its compilation.
Mat3 rotation_between(const Vec3& a, const Vec3& b) noexcept {
  constexpr double kOpposite = -1.0 + 1e-12;
  const Vec3 from = a.normalized(), to = b.normalized();
  const double c = to.dot(from);
  Eigen::Quaterniond q;
  if (c < kOpposite) {
    q.w() = 0.0;
    q.vec() = from.unitOrthogonal();
  } else {
    const double s = std::sqrt((1.0 + c) * 2.0);
    const Vec3 axis = from.cross(to);
    q.vec() = axis * (1.0 / s);
    q.w() = s * 0.5;
  }
  return q.toRotationMatrix();
}

}  // namespace palpate
