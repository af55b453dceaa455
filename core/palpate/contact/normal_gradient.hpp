// Derivative of a contact's normal with the centre of the sphere, by central differences.
//
// It is the curvature of the surface as the tool meets it, (I - n n^T) / (R + r - depth) on a sphere. The stage needs
// it only where the material changes under the tool, so no surface has to provide it.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// Step of the differences, in sphere radii [-].
inline constexpr double kNormalStep = 1e-4;

/// Derivative [1/m] of normal_at(displacement of the sphere [m]) in the two directions across `normal`. A normal that
/// is zero is unknown: the derivative along that direction is then zero.
template <class NormalAt>
Mat3 normal_gradient(const Vec3& normal, double radius, const NormalAt& normal_at) noexcept {
  Mat3 gradient = Mat3::Zero();
  const double h = kNormalStep * radius;
  const Vec3 first = normal.unitOrthogonal();
  for (const Vec3& t : {first, Vec3(normal.cross(first))}) {
    const Vec3 ahead = normal_at(Vec3(h * t)), behind = normal_at(Vec3(-h * t));
    if (ahead != Vec3::Zero() && behind != Vec3::Zero()) gradient += (ahead - behind) * (t.transpose() / (2.0 * h));
  }
  return gradient;
}

}  // namespace palpate::contact
