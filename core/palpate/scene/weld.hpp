// From a soup of corners to an indexed mesh: equal vertices become one, empty and repeated triangles go.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace palpate::scene {

struct Welded {
  std::vector<double> vertices;         ///< 3n, in order of first use
  std::vector<std::int32_t> triangles;  ///< 3m
  std::size_t degenerate = 0;           ///< dropped: a corner repeated, a line without surface
  std::size_t duplicate = 0;            ///< dropped: the same three corners in the same turn
};

/// Vertices are equal when their bits are (-0 counts as 0). Throws std::invalid_argument naming the first index out
/// of range, the first vertex that is not finite, or that no triangle is left.
Welded weld(std::span<const double> vertices, std::span<const std::int32_t> triangles);

}  // namespace palpate::scene
