// The thick disc around a small patch of surface. No Eigen here, as in bvh.hpp.
#pragma once

#include <array>
#include <limits>
#include <span>

namespace palpate::scene {

using Corner = std::array<double, 3>;

/// All x with |normal . (x - centre)| <= half that lie within `radius` of the axis through the centre.
struct Disc {
  std::array<float, 3> centre{};
  std::array<float, 3> normal{};  ///< at most a unit long; zero: the disc is a ball
  float radius = std::numeric_limits<float>::infinity();
  float half = 0.0F;
};

/// Around triangles, three corners each, at least one; the normal is their mean. Its numbers are rounded to nearest:
/// whoever measures to it takes more than that off.
Disc disc_around(std::span<const Corner> corners) noexcept;

}  // namespace palpate::scene
