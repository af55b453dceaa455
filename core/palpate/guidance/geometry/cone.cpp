#include "palpate/guidance/geometry/cone.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace palpate::guidance {

Cone::Cone(const Vec3& apex, const Vec3& axis, double half_angle)
    : apex_(apex), axis_(axis.normalized()), cosine_(std::cos(half_angle)), sine_(std::sin(half_angle)) {
  if (!apex.allFinite() || !axis.allFinite() || !(axis.norm() > 1e-9))
    throw std::invalid_argument("a cone needs a finite apex, and a mouth apart from it");
  if (!(half_angle > 0.0) || !(half_angle <= 0.5 * std::numbers::pi))
    throw std::invalid_argument("half the angle of a cone must be above 0 and at most pi / 2 rad, got " +
                                std::to_string(half_angle));
  attitude_ = basis_of(-axis_);
  aside_ = attitude_.col(0);
}

Query Cone::query_local(const Pose& X_WT, double, double) const noexcept {
  const Vec3 out = X_WT.p - apex_;
  const double z = axis_.dot(out);
  const Vec3 off = out - z * axis_;
  const double r = off.norm();
  const Vec3 radial = r > 0.0 ? Vec3(off / r) : aside_;
  const double along_side = z * cosine_ + r * sine_;
  Query q;
  if (along_side > 0.0) {
    q.distance = r * cosine_ - z * sine_;
    q.normal = cosine_ * radial - sine_ * axis_;
    q.point = apex_ + along_side * (cosine_ * axis_ + sine_ * radial);
  } else {  // behind the apex
    q.distance = out.norm();
    q.normal = q.distance > 0.0 ? Vec3(out / q.distance) : Vec3(-axis_);
    q.point = apex_;
  }
  q.basis = basis_of(q.normal);
  q.attitude = attitude_;
  return q;
}

}  // namespace palpate::guidance
