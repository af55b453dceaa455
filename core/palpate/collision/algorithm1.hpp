// The paper's Algorithm 1, line by line. collision_method.hpp runs it at two rates.
//
//   1 while collision
//   2   p_i, i = 1..z <= 15                     collision points (coal_surface.hpp)
//   3   n_i                                     their normals
//   4   n = sum n_i / |sum n_i|                 average; the previous one when the sum vanishes
//   5   delta_x_total = x_d - x                 x_d = x_c + d_j n_j of the deepest point j; x_c: x at the collision
//   6   xdot_total                              velocity of the tool
//   7   delta_x = (n . delta_x_total) n
//   8   xdot = (n . xdot_total) n
//   9   F = K delta_x - B xdot                  stage `force`
//
// The paper does not define x_d. This is the most favourable interpretation: the nearest position at which the sphere
// is free of its deepest triangle. It is exact on a plane, and wherever the facet below the centre is among the 15
// points.
#pragma once

#include "palpate/collision/coal_surface.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::collision::algorithm1 {

/// Contact plane of lines 2-5, updated at the collision rate. Its vectors are expressed in the frame of the collision
/// points.
struct GrownPlane {
  Vec3 n = Vec3::Zero();        ///< line 4, unit normal; zero: unknown
  Vec3 p_proxy = Vec3::Zero();  ///< x_d, position of the sphere centre free of collision [m]
};

/// Result of lines 5-8, updated at the rate of the haptic cycle. Its vectors are expressed in the frame of the plane.
struct Deflection {
  Vec3 delta_x_total = Vec3::Zero();  ///< line 5: deflection [m]
  Vec3 v_total = Vec3::Zero();        ///< line 6: velocity of the tool [m/s]
  Vec3 delta_x = Vec3::Zero();        ///< line 7: deflection along the normal [m]
  Vec3 v = Vec3::Zero();              ///< line 8: velocity along the normal [m/s]
};

/// The deepest collision point j. There must be at least one point.
[[nodiscard]] const CollisionPoint& deepest(const CollisionPoints& points) noexcept;

/// Line 4: average unit normal. n_last: normal of the previous collision, zero without one.
[[nodiscard]] Vec3 average_normal(const CollisionPoints& points, const Vec3& n_last) noexcept;

/// Line 4 and x_d for the sphere centre p [m], from at least one point.
[[nodiscard]] GrownPlane average(const CollisionPoints& points, const Vec3& n_last, const Vec3& p) noexcept;

/// Plane through the deepest point with the given normal n: x_d is where the sphere of `radius` [m] at p is free of it.
[[nodiscard]] GrownPlane through_deepest(const CollisionPoints& points, const Vec3& n, const Vec3& p,
                                         double radius) noexcept;

/// Lines 5-8 for the sphere centre p [m] and its velocity v [m/s].
[[nodiscard]] Deflection deflect(const GrownPlane& plane, const Vec3& p, const Vec3& v) noexcept;

}  // namespace palpate::collision::algorithm1
