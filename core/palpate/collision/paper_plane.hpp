// Method `paper-plane`: section 3.3 of the paper, Eqs 18-20 in three dimensions.
//
//   n . v_c = 0     (19)  contact points move along the surface: a plane is fitted to three or more of them
//   n . x_n >= 0    (20)  of its two normals, the one on the side of the last good normal x_n: "locally convex"
//
// The first x_n is the average normal of Algorithm 1 when the tool comes into contact. Then the method collects the
// points of each collision that are at least a baseline away from all kept points, and keeps them while they are within
// reach of the sphere. If the points lie on a line, or if the plane is at a right angle to x_n and Eq 20 cannot choose
// a side, the last good normal remains. At sharp concave edges Eq 20 chooses the side that points into the next wall.
// This is a limit of the published rule, and it is reproduced on purpose.
#pragma once

#include <array>
#include <span>

#include "palpate/collision/collision_method.hpp"

namespace palpate::collision {

/// Unit normal of the plane fitted to the points [m], on the side of n_last. Zero if it is undetermined: fewer than
/// three points, points on a line (second spread below a fifth of the first), a spread below the baseline [m], or a
/// plane at a right angle to n_last.
[[nodiscard]] Vec3 grow_plane(std::span<const Vec3> points, const Vec3& n_last, double baseline) noexcept;

/// Normal of a plane fitted to contact points; see the top of this file.
class PaperPlane final : public NormalRule {
 public:
  void free(const Vec3& v_OT) override;
  algorithm1::GrownPlane touch(const Collision& c) override;

 private:
  void gather(const Collision& c);

  Vec3 n_ = Vec3::Zero();                       // x_n in O; zero: no contact
  std::array<Vec3, kMaxCollisionPoints> kept_;  // kept contact points in O, the oldest first [m]
  int size_ = 0;
};

}  // namespace palpate::collision
