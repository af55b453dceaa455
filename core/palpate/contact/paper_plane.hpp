// Method `paper-plane`: the paper's section 3.3, Eqs 18-20 in three dimensions.
//
//   n . v_c = 0     (19)  contact points move along the surface: a plane is grown through three of them or more
//   n . x_n >= 0    (20)  of its two normals the one on the side of the last good normal x_n: "locally convex"
//
// The first x_n is Algorithm 1's average when the tool comes to touch. Then points are gathered while they stay in
// reach of the sphere: those of each collision that lie at least a baseline from all kept ones. Points on a line grow
// no plane, and a plane at a right angle to x_n has no side by Eq 20: the last good normal stays. On sharp concave
// edges Eq 20 picks the side that points into the next wall; that is the rule's limit, and it is shown, not hidden.
#pragma once

#include <array>
#include <span>

#include "palpate/contact/collision_method.hpp"

namespace palpate::contact {

/// The normal (unit) of the plane through points, on the side of n_last; zero when it cannot be told: fewer than three
/// points, on a line (second spread below a fifth of the first), spread below the baseline [m], at a right angle to
/// n_last.
[[nodiscard]] Vec3 grow_plane(std::span<const Vec3> points, const Vec3& n_last, double baseline) noexcept;

class PaperPlane final : public Rule {
 public:
  void free(const Vec3& v_OT) override;
  algorithm1::Plane touch(const Collision& c) override;

 private:
  void gather(const Collision& c);

  Vec3 n_ = Vec3::Zero();                       // x_n; zero: free
  std::array<Vec3, kMaxCollisionPoints> kept_;  // in O, the oldest first
  int size_ = 0;
};

}  // namespace palpate::contact
