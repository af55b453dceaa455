// Parts of a mesh and which way they face: neighbours should agree, and closed parts should not be inside out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "palpate/scene/topology.hpp"

namespace palpate::scene {

struct Winding {
  std::vector<bool> turn;    ///< triangles to turn; empty when there are none
  std::size_t turned = 0;    ///< of them, those that face the other way than their neighbours
  std::size_t inverted = 0;  ///< of them, those of closed parts that are inside out
  bool two_sided = true;     ///< false: a part has one side only (a Moebius strip), and no winding is right
  std::size_t parts = 0;     ///< connected by vertices
  double volume = 0.0;       ///< of the closed parts, cavities taken off, after turning [m^3]
};

/// First turns as few triangles as make neighbours agree. When none need it, turns closed parts of negative volume,
/// except cavities (an odd number of closed parts around them). So: turn, build the topology again, ask again.
Winding judge_winding(std::span<const double> vertices, std::span<const std::int32_t> triangles,
                      const Topology& topology);

/// Swaps two corners of each triangle to be turned.
void turn(std::vector<std::int32_t>& triangles, const std::vector<bool>& which);

}  // namespace palpate::scene
