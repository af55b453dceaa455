#include "palpate/guidance/geometry/combine.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate::guidance {
namespace {

/// The query of the complement: inside and outside are exchanged.
Query inside_out(Query q) noexcept {
  q.distance = -q.distance;
  q.normal = -q.normal;
  q.basis.rightCols<2>() *= -1.0;
  return q;
}

/// The nearer of two queries; a weighted mean of both while their distances differ by less than `blend` [m].
Query nearer(const Query& a, const Query& b, const Vec3& p, double blend) noexcept {
  Query q = a.distance <= b.distance ? a : b;
  const Query& other = a.distance <= b.distance ? b : a;
  const double h = blend > 0.0 ? std::max(1.0 - (other.distance - q.distance) / blend, 0.0) : 0.0;
  if (h == 0.0) return q;
  const double share = 0.5 * h;  // weight of the other query: d (blended distance) / d (other.distance)
  q.distance -= 0.25 * h * h * blend;
  const Vec3 gradient = (1.0 - share) * q.gradient_norm * q.normal + share * other.gradient_norm * other.normal;
  q.gradient_norm = gradient.norm();
  if (q.gradient_norm > 1e-9) q.normal = gradient / q.gradient_norm;
  q.point = p - q.distance * q.normal;
  q.velocity = (1.0 - share) * q.velocity + share * other.velocity;
  q.spin = (1.0 - share) * q.spin + share * other.spin;
  q.basis = basis_of(q.normal, q.basis.col(0));
  return q;
}

}  // namespace

Offset::Offset(GeometryPtr geometry, double margin) : geometry_(std::move(geometry)), margin_(margin) {
  if (geometry_ == nullptr || !std::isfinite(margin)) throw std::invalid_argument("a geometry and a finite margin [m]");
  if (!geometry_->solid() && !(margin > 0.0))
    throw std::invalid_argument("what has no inside (a point, a curve, an open mesh) needs a margin above zero [m]");
}

Query Offset::query_local(const Pose& X_WT, double t, double exact_within) const noexcept {
  Query q = geometry_->query(X_WT, t, exact_within + std::abs(margin_));
  const Vec3 shift = margin_ * q.normal;
  q.distance -= margin_;
  q.point += shift;
  q.velocity += q.spin.cross(shift);
  q.dimension = 2;
  return q;
}

Combination::Combination(Kind kind, std::vector<GeometryPtr> parts, double blend)
    : kind_(kind), parts_(std::move(parts)), blend_(blend) {
  if (parts_.empty()) throw std::invalid_argument("a combination needs parts");
  if (!(blend >= 0.0) || !std::isfinite(blend)) throw std::invalid_argument("blend must be zero or a length [m]");
  for (const GeometryPtr& part : parts_) {
    if (part == nullptr) throw std::invalid_argument("a part is missing");
    solid_ = solid_ && part->solid();
  }
  if (kind != Kind::unite && !solid_)
    throw std::invalid_argument("what has no inside (a point, a curve, an open mesh) cannot be cut; give it a margin");
}

/// By De Morgan's laws, an intersection or difference is the complement of a union.
Query Combination::query_local(const Pose& X_WT, double t, double) const noexcept {
  const bool cuts = kind_ != Kind::unite;
  Query q = parts_[0]->query(X_WT, t);
  if (cuts) q = inside_out(q);
  for (std::size_t i = 1; i < parts_.size(); ++i) {
    const Query part = parts_[i]->query(X_WT, t);
    q = nearer(q, kind_ == Kind::intersect ? inside_out(part) : part, X_WT.p, blend_);
  }
  return cuts ? inside_out(q) : q;
}

}  // namespace palpate::guidance
