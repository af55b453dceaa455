// Nearest point in the intersection of half-spaces: the optimisation problem of a proxy at faces, edges and corners.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// Half-space normal . x >= offset [m], with a unit normal.
struct HalfSpace {
  Vec3 normal = Vec3::Zero();  ///< unit normal, points into the half-space
  double offset = 0.0;         ///< distance of the plane from the origin along the normal [m]

  /// Signed distance of x from the plane; negative outside the half-space [m].
  [[nodiscard]] double gap(const Vec3& x) const noexcept { return normal.dot(x) - offset; }
};

inline constexpr double kSlack = 1e-10;  ///< violation of a half-space that counts as satisfied, in sphere radii [-]
/// Maximum number of half-spaces of one problem.
inline constexpr int kMaxHalfSpaces = 8;

/// Solution of project().
struct Projection {
  Vec3 x = Vec3::Zero();       ///< the nearest point [m]
  int active = 0;              ///< number of active half-spaces, whose planes contain x: 0 to 3
  std::array<int, 3> index{};  ///< indices of the active half-spaces, largest multiplier first
  bool feasible = true;        ///< false: no point in all half-spaces was found, x satisfies some of them
};

/// Computes the point nearest to g with gap >= -slack in all `n` half-spaces. g and slack in [m]. An active-set method,
/// exact for up to three active half-spaces.
Projection project(const HalfSpace* half_spaces, int n, const Vec3& g, double slack) noexcept;

}  // namespace palpate::contact
