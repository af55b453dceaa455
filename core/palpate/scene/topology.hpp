// What lies beside each triangle, and the smooth normals of the surface that the triangles stand for.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace palpate::scene {

/// Edges that turn more than this are creases: real edges of the thing, not facets of something round.
inline constexpr double kCreaseAngle = 0.52;  // a little below 30 degrees: walls at 150 degrees are two walls [rad]

using HalfEdgePair = std::array<std::int32_t, 2>;

/// Half-edge 3t + e runs from corner e to corner e + 1 of triangle t.
struct Topology {
  std::vector<std::int32_t> twin;    ///< 3m: the half-edge across, -1 on rims and where the surface branches
  std::vector<std::int32_t> normal;  ///< 3m: row of `normals` for each corner; corners share it unless creased
  std::vector<double> normals;       ///< 3k: unit, outwards
  std::vector<std::uint8_t> whole;   ///< k: all triangles around the vertex share this normal
  double height = 0.0;               ///< bound on how far the smooth surface leaves the triangles (smooth.hpp) [m]
  std::size_t branching_edges = 0;   ///< of three triangles or more
  std::size_t flat_triangles = 0;    ///< three corners on a line
  bool closed = false;               ///< every edge has two triangles, wound alike
  std::vector<std::int32_t> rims;    ///< half-edges of one triangle only
  std::vector<HalfEdgePair> clashes;  ///< half-edges whose two triangles run the same way
};

/// The half-edges after and before `he` in its triangle.
[[nodiscard]] constexpr std::int32_t next_half_edge(std::int32_t he) { return he % 3 == 2 ? he - 2 : he + 1; }
[[nodiscard]] constexpr std::int32_t previous_half_edge(std::int32_t he) { return he % 3 == 0 ? he + 2 : he - 1; }

Topology build_topology(std::span<const double> vertices, std::span<const std::int32_t> triangles);

}  // namespace palpate::scene
