// A point: a target, a trocar, a remote centre of motion.
#pragma once

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// The origin of its frame; the attitude is the identity.
class Point final : public Geometry {
 public:
  [[nodiscard]] bool solid() const noexcept override { return false; }
  [[nodiscard]] bool is_point() const noexcept override { return true; }
  [[nodiscard]] bool has_axis() const noexcept override { return false; }

 protected:
  [[nodiscard]] Query query_local(const Pose& X_WT, double, double) const noexcept override {
    return point_or_curve_query(X_WT.p, Vec3::Zero(), nullptr);
  }
};

}  // namespace palpate::guidance
