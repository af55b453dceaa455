// A cone without an end: the way from an entry to a target.
#pragma once

#include <numbers>

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// Of a cone that is named by its entry and its target alone [rad].
inline constexpr double kConeHalfAngle = 15.0 * std::numbers::pi / 180.0;

/// All places that are seen from the apex within `half_angle` of the axis. The attitude's z is the way in, to the apex.
/// Inside the normal turns at once where the axis is crossed.
class Cone final : public Geometry {
 public:
  /// axis: from the apex into the cone, any length; half_angle above 0, at most pi / 2 [rad].
  /// Throws std::invalid_argument naming what is wrong.
  Cone(const Vec3& apex, const Vec3& axis, double half_angle);
  [[nodiscard]] bool solid() const noexcept override { return true; }

 protected:
  [[nodiscard]] Query answer(const Pose& X_WT, double) const noexcept override;

 private:
  Vec3 apex_, axis_, aside_;
  double cosine_, sine_;
  Mat3 attitude_;
};

}  // namespace palpate::guidance
