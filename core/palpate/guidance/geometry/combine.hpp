// Geometries made from other geometries: offset, union, intersection, difference.
#pragma once

#include <algorithm>
#include <vector>

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// All points within `margin` of a geometry: a tube around a path, a ball around a point, a shell around an open mesh,
/// a grown solid, or, with a negative margin, a shrunk one.
///
/// d = d0 - margin. It is exact outside a grown and inside a shrunk geometry; elsewhere it is a lower bound of the
/// true distance.
class Offset final : public Geometry {
 public:
  /// Throws std::invalid_argument if the margin [m] is not finite, or not positive for a geometry without an inside.
  Offset(GeometryPtr geometry, double margin);
  [[nodiscard]] bool solid() const noexcept override { return true; }
  [[nodiscard]] bool has_axis() const noexcept override { return geometry_->has_axis(); }
  void add_live(LiveFrames& frames) const override { geometry_->add_live(frames); }

 protected:
  [[nodiscard]] Query query_local(const Pose& X_WT, double t, double exact_within) const noexcept override;

 private:
  GeometryPtr geometry_;
  double margin_;
};

/// Union: the smallest of the distances. Intersection: the largest. Difference: the first geometry without the others.
///
/// The distance is exact outside a union and inside an intersection or difference; elsewhere it is a lower bound of the
/// true distance. Where two parts are equally near, the normal jumps. With a `blend` [m] it turns gradually while their
/// distances differ by less than `blend`, and the distance is continuously differentiable; a crease is then filled by
/// at most (parts - 1) * blend / 4. The attitude is that of the nearest part.
class Combination final : public Geometry {
 public:
  enum class Kind { unite, intersect, subtract };
  /// Throws std::invalid_argument if there are no parts, if the blend is negative or not finite, or if a part of an
  /// intersection or difference has no inside.
  Combination(Kind kind, std::vector<GeometryPtr> parts, double blend);
  [[nodiscard]] bool solid() const noexcept override { return solid_; }
  [[nodiscard]] bool has_axis() const noexcept override {
    return std::all_of(parts_.begin(), parts_.end(), [](const GeometryPtr& part) { return part->has_axis(); });
  }
  void add_live(LiveFrames& frames) const override {
    for (const GeometryPtr& part : parts_) part->add_live(frames);
  }

 protected:
  [[nodiscard]] Query query_local(const Pose& X_WT, double t, double) const noexcept override;

 private:
  Kind kind_;
  std::vector<GeometryPtr> parts_;
  double blend_;
  bool solid_ = true;
};

}  // namespace palpate::guidance
