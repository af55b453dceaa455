// Geometries made of geometries: grown or shrunk, joined, cut.
#pragma once

#include <algorithm>
#include <vector>

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// Everything within `margin` of a geometry: a tube around a path, a ball around a point, a shell around an open mesh,
/// a solid grown, or, below zero, shrunk.
///
/// d = d0 - margin. Outside of what was grown, and inside of what was shrunk, it is exact; elsewhere never more than
/// the true distance.
class Offset final : public Geometry {
 public:
  /// Throws std::invalid_argument when margin [m] is not finite, or not above zero around something without an inside.
  Offset(GeometryPtr geometry, double margin);
  [[nodiscard]] bool solid() const noexcept override { return true; }
  [[nodiscard]] bool has_axis() const noexcept override { return geometry_->has_axis(); }
  void add_live(LiveFrames& frames) const override { geometry_->add_live(frames); }

 protected:
  [[nodiscard]] Query answer(const Pose& X_WT, double t) const noexcept override;

 private:
  GeometryPtr geometry_;
  double margin_;
};

/// Union: least of the distances. Intersection: greatest. Difference: the first without the others.
///
/// Exact outside of a union and inside of the others; elsewhere never more than the true distance. Where two parts are
/// equally near the normal turns at once; with a `blend` [m] it turns gradually while their distances differ by less
/// than that, and the distance is once differentiable: a crease is filled by at most (parts - 1) * blend / 4. The
/// attitude is that of the nearest part.
class Combination final : public Geometry {
 public:
  enum class Kind { unite, intersect, subtract };
  /// Throws std::invalid_argument: no parts, a blend that is no length, or parts without an inside that are cut.
  Combination(Kind kind, std::vector<GeometryPtr> parts, double blend);
  [[nodiscard]] bool solid() const noexcept override { return solid_; }
  [[nodiscard]] bool has_axis() const noexcept override {
    return std::all_of(parts_.begin(), parts_.end(), [](const GeometryPtr& part) { return part->has_axis(); });
  }
  void add_live(LiveFrames& frames) const override {
    for (const GeometryPtr& part : parts_) part->add_live(frames);
  }

 protected:
  [[nodiscard]] Query answer(const Pose& X_WT, double t) const noexcept override;

 private:
  Kind kind_;
  std::vector<GeometryPtr> parts_;
  double blend_;
  bool solid_ = true;
};

}  // namespace palpate::guidance
