// A cloud of points, each with a ball around it: what a depth camera or a tracked probe leaves.
#pragma once

#include <span>
#include <vector>

#include "palpate/scene/bvh.hpp"
#include "palpate/scene/surface.hpp"

namespace palpate::scene {

/// All places within `radius` of a point. Outside the distance is exact; inside never more than the true depth.
class Cloud final : public Surface {
 public:
  /// points: 3n doubles [m]; radius above zero [m].
  /// Throws std::invalid_argument naming what is wrong: no points, numbers that are not finite or beyond 1e9 m.
  Cloud(std::span<const double> points, double radius);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;

 private:
  std::vector<double> points_;
  double radius_;
  Bvh bvh_;  // over triangles that are but a point each
};

}  // namespace palpate::scene
