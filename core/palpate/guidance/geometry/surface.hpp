// Every kind of surface in a scene as a geometry: plane, sphere, box, cylinder, capsule, implicit surface, mesh, cloud,
// distance grid. The distance queries are those of the contact stage.
#pragma once

#include "palpate/guidance/geometry.hpp"
#include "palpate/scene/surface.hpp"

namespace palpate::guidance {

/// A surface of the scene, in its frame O. In the haptic cycle a surface that deforms is queried as it is deformed
/// (scene/deformed_scope.hpp). Inside a box, a cylinder or a mesh the normal jumps where two walls are
/// equally near (the medial axis). Outside it is continuous where the nearest point is unique.
class Solid final : public Geometry {
 public:
  /// Throws std::invalid_argument when the pointer is null.
  explicit Solid(std::shared_ptr<const scene::Surface> surface);
  /// False for an open mesh, whose distance is unsigned.
  [[nodiscard]] bool solid() const noexcept override { return closed_; }
  [[nodiscard]] bool has_axis() const noexcept override { return axis_; }

 protected:
  [[nodiscard]] Query query_local(const Pose& X_WT, double, double exact_within) const noexcept override;

 private:
  std::shared_ptr<const scene::Surface> surface_;
  bool closed_, axis_, soft_;
};

}  // namespace palpate::guidance
