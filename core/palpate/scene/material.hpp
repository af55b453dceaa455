// Material of an object and its variation in space.
#pragma once

#include "palpate/types/contact.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// Region of an object with a different material: a box with rounded edges, in the object's frame O. With half lengths
/// of zero it is a ball.
struct Region {
  Vec3 centre = Vec3::Zero();  ///< centre of the box [m]
  Vec3 half = Vec3::Zero();    ///< half lengths of the box [m]
  double radius = 0.0;         ///< radius of the ball or of the rounded edges, added around the box [m]
  double blend = 0.001;        ///< width of the transition to the surrounding material [m]
  Material material;           ///< material inside the region

  /// Weight of the region's material at p_O [-]: 1 inside, 0 farther away than `blend`, smooth in between. Sets `slope`
  /// to the gradient of the weight [1/m].
  double weight(const Vec3& p_O, Vec3& slope) const noexcept;
};

/// Material of an object at a point, with the gradient of the stiffness.
struct LocalMaterial {
  Material material;       ///< material at the point
  Mat3 dK = Mat3::Zero();  ///< row i is the gradient of K_i, in O [N/m^2]

  /// Blends the material at p_O with the material of `region`.
  void blend(const Region& region, const Vec3& p_O) noexcept;
};

}  // namespace palpate::scene
