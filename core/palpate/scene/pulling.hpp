// Soft regions that would pull a tool in.
//
// The energy of a contact is 1/2 K d^2 with the stiffness K at the sphere's deepest point, which lies at the depth d.
// On the way into a softer region K falls; where it falls faster than d^2 grows, the energy falls with the depth, and
// the force would pull. A surface never pulls, and a force without that part is no gradient: closed paths would gain
// energy.
#pragma once

#include <optional>
#include <string>

#include "palpate/scene/snapshot.hpp"

namespace palpate::scene {

/// Largest force that a tool is assumed to press with; deeper points are out of its reach [N].
inline constexpr double kMostPressed = 50.0;

/// The place where an object's regions pull the most.
struct Pull {
  int region = -1;          ///< index of the region in whose blend the place lies
  double depth = 0.0;       ///< depth of the place below the surface [m]
  double excess = 0.0;      ///< -d K/d depth times depth / 2 K: above 1, the force pulls [-]
  Vec3 p_O = Vec3::Zero();  ///< the place, in the object's frame [m]
};

/// The strongest pull of an object's regions, or nothing if none pulls. It takes milliseconds for each region that is
/// softer than the object.
std::optional<Pull> strongest_pull(const Object& object);

/// What a person should know about a pull: where it is, and the least blend or stiffness without it. It takes up to
/// some hundred milliseconds.
std::string words(const Object& object, const Pull& pull);

}  // namespace palpate::scene
