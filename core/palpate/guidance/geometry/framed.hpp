// A geometry in a frame: fixed in the world, moving in closed form, or set live from outside.
#pragma once

#include <memory>

#include "palpate/guidance/geometry.hpp"
#include "palpate/scene/frame.hpp"

namespace palpate::guidance {

/// A geometry at the pose X_FG in a frame.
class FramedGeometry final : public Geometry {
 public:
  /// Throws std::invalid_argument when a pointer is null.
  FramedGeometry(GeometryPtr geometry, const Pose& X_FG, std::shared_ptr<const scene::Frame> frame);
  [[nodiscard]] bool solid() const noexcept override { return geometry_->solid(); }
  [[nodiscard]] bool is_point() const noexcept override { return geometry_->is_point(); }
  /// True also for a geometry without an axis of its own if it is rotated or its frame is live.
  [[nodiscard]] bool has_axis() const noexcept override;
  void add_live(LiveFrames& frames) const override;
  [[nodiscard]] QueryDerivatives normals(const Pose& X_WT, double t) const noexcept override;

 protected:
  [[nodiscard]] Query query_local(const Pose& X_WT, double t, double exact_within) const noexcept override;

 private:
  GeometryPtr geometry_;
  Pose X_FG_;
  std::shared_ptr<const scene::Frame> frame_;
};

}  // namespace palpate::guidance
