// Welding: converts a triangle soup to an indexed mesh. Equal vertices become one; degenerate and repeated triangles
// are dropped.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace palpate::scene {

/// Result of weld().
struct Welded {
  std::vector<double> vertices;         ///< (3n) coordinates, in order of first use [m]
  std::vector<std::int32_t> triangles;  ///< (3m) vertex indices
  std::size_t degenerate = 0;           ///< number of triangles dropped for a repeated corner
  std::size_t duplicate = 0;  ///< number of triangles dropped as repetitions: the same corners in the same orientation
};

/// Welds vertices with bitwise equal coordinates (-0 counts as 0). vertices: 3n coordinates [m]; triangles: 3m indices.
/// Throws std::invalid_argument with the first index out of range, the first vertex that is not finite, or the message
/// that no triangle is left.
Welded weld(std::span<const double> vertices, std::span<const std::int32_t> triangles);

}  // namespace palpate::scene
