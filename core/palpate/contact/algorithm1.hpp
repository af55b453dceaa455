// The paper's Algorithm 1, line by line. collision_method.hpp runs it at two rates.
//
//   1 while collision
//   2   p_i, i = 1..z <= 15                     collision points (coal_surface.hpp)
//   3   n_i                                     their normals
//   4   n = sum n_i / |sum n_i|                 average; the last one when the sum vanishes
//   5   delta_x_total = x_d - x                 x_d = x + d_j n_j of the deepest point j, when it was collided
//   6   xdot_total                              of the tool
//   7   delta_x = (n . delta_x_total) n
//   8   xdot = (n . xdot_total) n
//   9   F = K delta_x - B xdot                  stage `force`
//
// The paper does not say where x_d comes from. Of the readings this is the kindest: the nearest place where the sphere
// is free of its deepest triangle, exact on a plane and wherever the facet below the centre is among the 15 points.
#pragma once

#include "palpate/contact/coal_surface.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::contact::algorithm1 {

/// Lines 2-5, at the rate of collisions. In one frame, that of the points.
struct Plane {
  Vec3 n = Vec3::Zero();        ///< line 4, unit; zero: not known
  Vec3 p_proxy = Vec3::Zero();  ///< x_d [m]
};

/// Lines 5-8, at the rate of the haptic cycle. In the same frame.
struct Deflection {
  Vec3 delta_x_total = Vec3::Zero();  ///< line 5 [m]
  Vec3 v_total = Vec3::Zero();        ///< line 6 [m/s]
  Vec3 delta_x = Vec3::Zero();        ///< line 7 [m]
  Vec3 v = Vec3::Zero();              ///< line 8 [m/s]
};

/// The point j of at least one.
[[nodiscard]] const CollisionPoint& deepest(const CollisionPoints& points) noexcept;

/// Line 4; n_last: the normal of the last collision, zero when there was none.
[[nodiscard]] Vec3 average_normal(const CollisionPoints& points, const Vec3& n_last) noexcept;

/// Line 4 and x_d from at least one point, for the sphere's centre p.
[[nodiscard]] Plane average(const CollisionPoints& points, const Vec3& n_last, const Vec3& p) noexcept;

/// The plane through the deepest point with a normal n from elsewhere: x_d is where the sphere at p is free of it.
[[nodiscard]] Plane through_deepest(const CollisionPoints& points, const Vec3& n, const Vec3& p,
                                    double radius) noexcept;

[[nodiscard]] Deflection deflect(const Plane& plane, const Vec3& p, const Vec3& v) noexcept;

}  // namespace palpate::contact::algorithm1
