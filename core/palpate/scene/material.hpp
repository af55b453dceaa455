// How an object feels, and where in it that changes.
#pragma once

#include "palpate/types/contact.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// Part of an object that feels otherwise, in the object's frame O: a box with round edges. A box of no size is a ball.
struct Region {
  Vec3 centre = Vec3::Zero();  ///< [m]
  Vec3 half = Vec3::Zero();    ///< half the lengths of the box [m]
  double radius = 0.0;         ///< around the box: of the ball, or of the round edges [m]
  double blend = 0.001;        ///< over which it fades into what is around it [m]
  Material material;

  /// 1 inside, 0 further away than `blend`, smooth in between; `slope` becomes its gradient [1/m].
  double weight(const Vec3& p_O, Vec3& slope) const noexcept;
};

/// How an object feels at a point.
struct Feel {
  Material material;
  Mat3 dK = Mat3::Zero();  ///< row i: gradient of K_i, in O [N/m^2]

  /// What `region` makes of it at p_O.
  void blend(const Region& region, const Vec3& p_O) noexcept;
};

}  // namespace palpate::scene
