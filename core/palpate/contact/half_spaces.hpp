// Nearest point of an intersection of half-spaces: the small problem behind faces, edges and corners.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// normal . x >= offset, with a unit normal.
struct HalfSpace {
  Vec3 normal = Vec3::Zero();
  double offset = 0.0;

  [[nodiscard]] double gap(const Vec3& x) const noexcept { return normal.dot(x) - offset; }
};

inline constexpr double kSlack = 1e-10;  ///< [radius of the sphere] violation of a half-space that counts as kept
inline constexpr int kMaxHalfSpaces = 8;

struct Projection {
  Vec3 x = Vec3::Zero();
  int active = 0;              ///< how many half-spaces hold x, 0 to 3
  std::array<int, 3> index{};  ///< which, strongest first
  bool feasible = true;        ///< false: no common point was found, x is the best of a few
};

/// The point nearest to g with gap >= -slack in all `n` half-spaces (an active-set method, exact for up to three).
Projection project(const HalfSpace* half_spaces, int n, const Vec3& g, double slack) noexcept;

}  // namespace palpate::contact
