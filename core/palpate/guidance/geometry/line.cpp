#include "palpate/guidance/geometry/line.hpp"

#include <algorithm>
#include <stdexcept>

namespace palpate::guidance {

Line::Line(const Vec3& a, const Vec3& b, bool endless)
    : a_(a), direction_((b - a).normalized()), length_((b - a).norm()), endless_(endless) {
  if (!a.allFinite() || !b.allFinite() || !(length_ > 1e-9))
    throw std::invalid_argument("a line needs two places that are finite and apart");
  attitude_ = basis_of(direction_);
}

Query Line::query_local(const Pose& X_WT, double, double) const noexcept {
  const double wanted = direction_.dot(X_WT.p - a_);
  const double arc_length = endless_ ? wanted : std::clamp(wanted, 0.0, length_);
  Query q = point_or_curve_query(X_WT.p, a_ + arc_length * direction_, arc_length == wanted ? &direction_ : nullptr);
  q.arc_length = arc_length;
  q.attitude = attitude_;
  return q;
}

}  // namespace palpate::guidance
