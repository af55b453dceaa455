// A point cloud with a ball around each point, for example from a depth camera or a tracked probe.
#pragma once

#include <span>
#include <vector>

#include "palpate/scene/bvh.hpp"
#include "palpate/scene/surface.hpp"

namespace palpate::scene {

/// The union of the balls of `radius` around the points. Outside the distance is exact. Inside its magnitude is never
/// more than the true depth.
class Cloud final : public Surface {
 public:
  /// points: 3n coordinates [m]; radius: above zero [m]. Throws std::invalid_argument with the reason: no points, or
  /// coordinates that are not finite or beyond 1e9 m.
  Cloud(std::span<const double> points, double radius);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;

 private:
  std::vector<double> points_;
  double radius_;
  Bvh bvh_;  // hierarchy over degenerate triangles, one for each point
};

}  // namespace palpate::scene
