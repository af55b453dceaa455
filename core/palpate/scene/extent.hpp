// Meshes whose numbers leave no room to compute with are refused, with the numbers.
#pragma once

#include <cstdint>
#include <span>

namespace palpate::scene {

inline constexpr double kFarthest = 1e9;       ///< largest coordinate [m]
inline constexpr double kSmallest = 1e-9;      ///< smallest extent [m]
inline constexpr double kFinestOfAll = 1e-6;   ///< half of the triangles may be this much smaller than the mesh
inline constexpr double kFinestOfFar = 1e-10;  ///< and this much smaller than its distance from the origin

/// Throws std::invalid_argument when the mesh is larger, smaller, farther away or finer than that.
void require_extent(std::span<const double> vertices, std::span<const std::int32_t> triangles);

}  // namespace palpate::scene
