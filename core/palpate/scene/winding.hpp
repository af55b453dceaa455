// Orientation of the triangles of a mesh: neighbours must agree, and closed components must not be inside out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "palpate/scene/topology.hpp"

namespace palpate::scene {

/// Result of check_orientation(). A component is a set of triangles connected by vertices.
struct Winding {
  std::vector<bool> flip;      ///< (m) true for triangles to flip; empty when there are none
  std::size_t flipped = 0;     ///< number of triangles to flip because they face the other way than their neighbours
  std::size_t inverted = 0;    ///< number of triangles to flip because their closed component is inside out
  bool two_sided = true;       ///< false: a component has only one side (Moebius strip), and no orientation is right
  std::size_t components = 0;  ///< number of components
  double volume = 0.0;         ///< volume of the closed components without cavities, after flipping [m^3]
};

/// Finds the triangles to flip. First it flips the smallest number of triangles that makes neighbours agree. If no
/// triangle needs this, it flips closed components with negative volume, except cavities (components inside an odd
/// number of other closed components). The caller therefore flips, rebuilds the topology and calls again.
Winding check_orientation(std::span<const double> vertices, std::span<const std::int32_t> triangles,
                          const Topology& topology);

/// Flips the triangles with a true entry in `which` (m), by swapping two corners.
void flip(std::vector<std::int32_t>& triangles, const std::vector<bool>& which);

}  // namespace palpate::scene
