// A straight line, with ends or without.
#pragma once

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// From a to b; `along` counts from a, the attitude's z points from a to b. Beyond an end it is a point
/// (`dimension` 0): there the direction along the line is no longer free.
class Line final : public Geometry {
 public:
  /// endless: goes on through both. Throws std::invalid_argument unless a and b are finite and apart [m].
  Line(const Vec3& a, const Vec3& b, bool endless);
  [[nodiscard]] bool solid() const noexcept override { return false; }

 protected:
  [[nodiscard]] Query answer(const Pose& X_WT, double) const noexcept override;

 private:
  Vec3 a_, direction_;
  double length_;
  bool endless_;
  Mat3 attitude_;
};

}  // namespace palpate::guidance
