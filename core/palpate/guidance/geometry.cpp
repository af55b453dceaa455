#include "palpate/guidance/geometry.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "palpate/types/so3.hpp"

namespace palpate::guidance {
namespace {

constexpr double kMaxTime = 1e9;  // [s] times are clamped to it
constexpr double kMinCoordinate =
    1e-100;                     // [m] smaller coordinates become zero, so that their squares cannot underflow
constexpr double kStep = 2e-6;  // [m] step of the differences: truncation and rounding errors are both about 1e-6

Mat3 at_most(double most, const Mat3& slope) noexcept {
  const double norm = slope.norm();
  return norm > most ? Mat3(most / norm * slope) : slope;
}

}  // namespace

Query Geometry::query(const Pose& X_WT, double t, double exact_within) const noexcept {
  Vec3 p = X_WT.p.cwiseMax(-kMaxCoordinate).cwiseMin(kMaxCoordinate);
  p = (p.array().abs() < kMinCoordinate).select(0.0, p);
  return query_local({X_WT.R, p}, std::clamp(t, -kMaxTime, kMaxTime), exact_within);
}

QueryDerivatives Geometry::normals(const Pose& X_WT, double t) const noexcept {
  QueryDerivatives out;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vec3 step = kDifferenceStep * Vec3::Unit(k);
    const Query after = query({X_WT.R, X_WT.p + step}, t), before = query({X_WT.R, X_WT.p - step}, t);
    out.normal[k] = 0.5 / kDifferenceStep * (after.distance - before.distance);
    out.d_normal.row(k) =
        0.5 / kDifferenceStep * (after.gradient_norm * after.normal - before.gradient_norm * before.normal);
  }
  return out;
}

QueryDerivatives Geometry::attitude_derivative(const Pose& X_WT, double t) const noexcept {
  QueryDerivatives out;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vec3 step = kStep * Vec3::Unit(k);
    const Query after = query({X_WT.R, X_WT.p + step}, t), before = query({X_WT.R, X_WT.p - step}, t);
    out.d_attitude.col(k) = 0.5 / kStep * rotation_vector(after.attitude * before.attitude.transpose());
  }
  out.d_attitude = at_most(kMaxTurnPerLength, out.d_attitude);
  return out;
}

Mat3 basis_of(const Vec3& normal) noexcept { return basis_of(normal, normal); }

Mat3 basis_of(const Vec3& normal, const Vec3& along) noexcept {
  Vec3 left = along - normal.dot(along) * normal;
  if (!(left.norm() > 1e-6)) {  // parallel to the normal: take the coordinate axis farthest from it
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

Query point_or_curve_query(const Vec3& p, const Vec3& point, const Vec3* tangent) noexcept {
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
  // The normal is perpendicular to the tangent even where p - point is mostly rounding error: the tangent stays free.
  const Vec3 across = out - tangent->dot(out) * *tangent;
  const double length = across.norm();
  q.normal = length > 1e-12 ? Vec3(across / length) : Vec3(basis_of(*tangent).col(0));
  q.basis = basis_of(q.normal, *tangent);
  return q;
}

}  // namespace palpate::guidance
