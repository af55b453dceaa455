// Check that the coordinates of a mesh leave enough floating-point precision for distance queries.
#pragma once

#include <cstdint>
#include <span>

namespace palpate::scene {

inline constexpr double kMaxCoordinate = 1e9;        ///< largest allowed coordinate [m]
inline constexpr double kMinExtent = 1e-9;           ///< smallest allowed extent of a mesh [m]
inline constexpr double kMinSizeToExtent = 1e-6;     ///< smallest ratio of median triangle size to mesh extent [-]
inline constexpr double kMinSizeToDistance = 1e-10;  ///< smallest ratio of median triangle size to origin distance [-]

/// Throws std::invalid_argument if the mesh violates one of these limits. vertices: 3n coordinates [m]; triangles: 3m
/// indices.
void require_extent(std::span<const double> vertices, std::span<const std::int32_t> triangles);

}  // namespace palpate::scene
