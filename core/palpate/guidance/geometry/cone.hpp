// An infinite cone, such as the access corridor from an entry to a target.
#pragma once

#include <numbers>

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// All points whose direction from the apex lies within `half_angle` of the axis. The attitude's z points along the
/// axis towards the apex. Inside, the normal jumps where the axis is crossed.
class Cone final : public Geometry {
 public:
  /// axis: from the apex into the cone, any length; half_angle above 0, at most pi / 2 [rad].
  /// Throws std::invalid_argument naming the bad value.
  Cone(const Vec3& apex, const Vec3& axis, double half_angle);
  [[nodiscard]] bool solid() const noexcept override { return true; }

 protected:
  [[nodiscard]] Query query_local(const Pose& X_WT, double, double) const noexcept override;

 private:
  Vec3 apex_, axis_, aside_;
  double cosine_, sine_;
  Mat3 attitude_;
};

}  // namespace palpate::guidance
