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

Query Line::answer(const Pose& X_WT, double) const noexcept {
  const double wanted = direction_.dot(X_WT.p - a_);
  const double along = endless_ ? wanted : std::clamp(wanted, 0.0, length_);
  Query q = towards(X_WT.p, a_ + along * direction_, along == wanted ? &direction_ : nullptr);
  q.along = along;
  q.attitude = attitude_;
  return q;
}

}  // namespace palpate::guidance
