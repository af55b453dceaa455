// The surface through a point cloud, as seen by a depth camera or a scanner.
//
// Near the query point the points and their normals are fitted by an algebraic sphere with weights that fall to zero
// within the support h (algebraic point set surfaces: Guennebaud and Gross, ACM TOG 26(3), 2007, with the closed form
// of Guennebaud, Germann and Gross, CGF 27(2), 2008). A plane fitted by moving least squares would lie below every
// convex surface by about h^2 / (16 R), with the radius of curvature R: at h = 8 mm and R = 30 mm that is 0.13 mm,
// which is force. A sphere follows the curvature and remains stable for noisy points. The foot point of the query is
// found by repeated projection, so that the distance is the length of the shortest path to the surface.
//
// The points are moved onto the surface once, when it is built; queries then fit fewer of them. In a query:
//
// * Points whose normals oppose the normal of the nearest point belong to another sheet and are left out.
// * The surface ends where no point is nearer than `bridge`: smaller gaps are closed, and rims are round.
// * The surface is the front of a layer of thickness `thickness`, in which the distance is negative. The layer decides
//   which side is outside; behind it is free space, because a camera cannot see how thick the object is.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "palpate/clouds/point_grid.hpp"
#include "palpate/scene/bvh.hpp"
#include "palpate/scene/surface.hpp"

namespace palpate::clouds {

/// Options of the surface through a cloud. All above zero [m].
struct PointSurfaceOptions {
  double voxel = 1e-3;      ///< points in one cube with this side are averaged
  double support = 6e-3;    ///< radius within which points shape the surface
  double bridge = 3e-3;     ///< distance from the nearest point at which the surface ends
  double thickness = 0.02;  ///< thickness of the solid layer behind the surface
};

/// Input of a surface: points, and what orients their normals.
struct PointInput {
  std::span<const double> points;   ///< 3n coordinates [m]
  std::span<const double> normals;  ///< 3n components, (0, 0, 0): unknown; empty: all are unknown
  std::optional<Vec3> viewpoint;    ///< position of the sensor; unknown normals point towards it [m]
};

/// Surface through a point cloud, in its own frame O.
class PointSurface final : public scene::Surface {
 public:
  /// continues: the surface of the previous frame of the same stream, whose id the new one takes, so that contact goes
  /// on; null: a new surface. Without any point the surface cannot be touched. Throws std::invalid_argument: a value is
  /// not finite or out of range.
  PointSurface(const PointInput& input, const PointSurfaceOptions& options, const PointSurface* continues = nullptr);
  [[nodiscard]] scene::Nearest nearest(const Vec3& p) const noexcept override;
  [[nodiscard]] bool is_exact() const noexcept override { return false; }

  /// Displacement by which this surface moved to pass through the points (3n coordinates) within `radius` of `centre`
  /// [m]: the translation with the least squared distances. It is zero along directions that the shape does not
  /// determine, and empty if fewer than 30 points have a counterpart.
  [[nodiscard]] std::optional<Vec3> shift_to(std::span<const double> points, const Vec3& centre, double radius) const;
  /// Moves the surface by d [m]. Only before it is handed to a loop.
  void translate(const Vec3& d) noexcept { grid_.translate(d); }
  /// The averaged points with their normals.
  [[nodiscard]] const PointGrid& grid() const noexcept { return grid_; }
  [[nodiscard]] const PointSurfaceOptions& options() const noexcept { return options_; }

 private:
  struct Foot;
  [[nodiscard]] Foot foot(const Vec3& p, std::int32_t start, int projections) const noexcept;

  PointSurfaceOptions options_;
  PointGrid grid_;
  scene::Bvh bvh_;  // hierarchy over degenerate triangles, one for each point
};

}  // namespace palpate::clouds
