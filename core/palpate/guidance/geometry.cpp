#include "palpate/guidance/geometry.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::guidance {
namespace {

constexpr double kLongest = 1e9;  // [s]

}  // namespace

Query Geometry::query(const Pose& X_WT, double t) const noexcept {
  const Vec3 p = X_WT.p.cwiseMax(-kFarthest).cwiseMin(kFarthest);
  return answer({X_WT.R, p}, std::clamp(t, -kLongest, kLongest));
}

Mat3 basis_of(const Vec3& normal) noexcept { return basis_of(normal, normal); }

Mat3 basis_of(const Vec3& normal, const Vec3& along) noexcept {
  Vec3 left = along - normal.dot(along) * normal;
  if (!(left.norm() > 1e-6)) {  // along the normal: any other will do
    int least = 0;
    normal.cwiseAbs().minCoeff(&least);
    left = Vec3::Unit(least) - normal[least] * normal;
  }
  Mat3 basis;
  basis.col(0) = left.normalized();
  basis.col(1) = normal.cross(basis.col(0));
  basis.col(2) = normal;
  return basis;
}

Query towards(const Vec3& p, const Vec3& point, const Vec3* tangent) noexcept {
  Query q;
  const Vec3 out = p - point;
  q.distance = out.norm();
  q.point = point;
  q.dimension = tangent == nullptr ? 0 : 1;
  if (tangent == nullptr) {
    if (q.distance > 0.0) q.normal = out / q.distance;
    q.basis = basis_of(q.normal);
    return q;
  }
  // Across the curve even where the way out is mostly rounding: what is free there is the tangent.
  const Vec3 across = out - tangent->dot(out) * *tangent;
  const double length = across.norm();
  q.normal = length > 1e-12 ? Vec3(across / length) : Vec3(basis_of(*tangent).col(0));
  q.basis = basis_of(q.normal, *tangent);
  return q;
}

}  // namespace palpate::guidance
