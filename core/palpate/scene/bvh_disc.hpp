// The thick disc that bounds a small patch of surface. Like bvh.hpp, this header does not use Eigen.
#pragma once

#include <array>
#include <limits>
#include <span>

namespace palpate::scene {

/// Position of a triangle's corner, in the coordinates of the BVH.
using Corner = std::array<double, 3>;

/// The points x with |normal . (x - centre)| <= half and within `radius` of the axis through the centre along the
/// normal.
struct Disc {
  std::array<float, 3> centre{};                          ///< centre of the disc
  std::array<float, 3> normal{};                          ///< length 1 or less; zero: the disc is a ball
  float radius = std::numeric_limits<float>::infinity();  ///< radius across the normal; infinity: no disc
  float half = 0.0F;                                      ///< half of the thickness, along the normal
};

/// Disc around one or more triangles, given by three corners each. Its normal is the mean normal of the triangles. The
/// numbers are rounded to nearest, so distances to the disc need a margin for rounding errors.
Disc disc_around(std::span<const Corner> corners) noexcept;

}  // namespace palpate::scene
