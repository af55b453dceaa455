// Adjacency of the triangles of a mesh, and the normals of the smooth surface that the mesh approximates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "palpate/scene/stored.hpp"

namespace palpate::scene {

/// Edges with a larger angle between the normals of their triangles are creases: real edges of the object, not facets
/// of a rounded surface.
inline constexpr double kCreaseAngle = 0.52;  // just below 30 degrees: walls at 150 degrees form a crease [rad]

using HalfEdgePair = std::array<std::int32_t, 2>;

/// Topology of m triangles. Half-edge 3t + e runs from corner e to the next corner of triangle t.
struct Topology {
  Stored<std::int32_t> twin;    ///< (3m) half-edge of the adjacent triangle; -1 at boundaries and branching edges
  Stored<std::int32_t> normal;  ///< (3m) row of `normals` for each corner; shared between corners without crease
  Stored<double> normals;       ///< (3k) outward unit normals
  Stored<std::uint8_t> smooth_vertex;  ///< (k) true: all triangles around the vertex share this normal
  double height = 0.0;  ///< bound on the distance between the smooth surface and the triangles (smooth.hpp) [m]
  std::size_t branching_edges = 0;               ///< number of edges of three or more triangles
  std::size_t flat_triangles = 0;                ///< number of triangles with three collinear corners
  bool closed = false;                           ///< true: every edge has two triangles of the same orientation
  std::vector<std::int32_t> rims;                ///< half-edges of boundary edges, which have only one triangle
  std::vector<HalfEdgePair> inconsistent_pairs;  ///< half-edge pairs of equal direction
};

/// The next and the previous half-edge of the same triangle.
[[nodiscard]] constexpr std::int32_t next_half_edge(std::int32_t he) { return he % 3 == 2 ? he - 2 : he + 1; }
[[nodiscard]] constexpr std::int32_t previous_half_edge(std::int32_t he) { return he % 3 == 0 ? he + 2 : he - 1; }

/// Builds the topology. vertices: 3n coordinates [m]; triangles: 3m indices.
Topology build_topology(std::span<const double> vertices, std::span<const std::int32_t> triangles);

}  // namespace palpate::scene
