// A straight line, finite or infinite.
#pragma once

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// The line from a to b; `arc_length` is measured from a, and the attitude's z points from a to b. Beyond an end the
/// line acts like a point (`dimension` 0): motion along its direction is no longer free there.
class Line final : public Geometry {
 public:
  /// endless: the line continues beyond a and b. Throws std::invalid_argument unless a and b are finite and distinct
  /// [m].
  Line(const Vec3& a, const Vec3& b, bool endless);
  [[nodiscard]] bool solid() const noexcept override { return false; }

 protected:
  [[nodiscard]] Query query_local(const Pose& X_WT, double, double) const noexcept override;

 private:
  Vec3 a_, direction_;
  double length_;
  bool endless_;
  Mat3 attitude_;
};

}  // namespace palpate::guidance
