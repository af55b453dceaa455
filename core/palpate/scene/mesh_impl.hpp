// Internal data of a mesh, for stages that follow a point on its surface from tick to tick.
#pragma once

#include <cstdint>
#include <memory>

#include "palpate/scene/bvh.hpp"
#include "palpate/scene/mesh.hpp"
#include "palpate/scene/stored.hpp"
#include "palpate/scene/topology.hpp"

namespace palpate::scene {

/// A point of the surface, with barycentric weights u, v, w of a triangle: corner 0 + v (corner 1 - corner 0) + w
/// (corner 2 - corner 0).
struct SurfacePoint {
  std::int32_t triangle = -1;  ///< index of the (welded) triangle; -1: none
  double v = 0.0;              ///< weight of corner 1 [-]
  double w = 0.0;              ///< weight of corner 2 [-]

  /// Weight of corner 0 [-].
  [[nodiscard]] double u() const noexcept { return 1.0 - v - w; }
};

/// Aligned bytes of an image.
struct alignas(kImageAlignment) Aligned {
  std::uint8_t bytes[kImageAlignment];
};

/// Data of a Mesh.
struct Mesh::Impl {
  Stored<double> vertices;           ///< 3 coordinates per vertex [m]
  Stored<std::int32_t> triangles;    ///< 3 vertex indices per triangle
  Topology topology;                 ///< adjacency and smooth normals
  Bvh bvh;                           ///< hierarchy of the triangles
  MeshReport report;                 ///< defects found and repaired
  std::unique_ptr<Aligned[]> image;  ///< the image that the arrays lie in, if the mesh keeps it itself
  double travelled = 0.0;            ///< bound on the way of every vertex since the mesh was built [m]

  /// Position of the corner at the start of a half-edge [m].
  [[nodiscard]] Vec3 corner(std::int32_t half_edge) const noexcept {
    return Vec3(&vertices[3 * static_cast<std::size_t>(triangles[static_cast<std::size_t>(half_edge)])]);
  }
  /// Smooth unit normal at this corner (topology.hpp).
  [[nodiscard]] Vec3 normal(std::int32_t half_edge) const noexcept {
    return Vec3(&topology.normals[3 * static_cast<std::size_t>(topology.normal[static_cast<std::size_t>(half_edge)])]);
  }
  /// Position of a surface point on its facet [m].
  [[nodiscard]] Vec3 position(const SurfacePoint& s) const noexcept {
    const std::int32_t c = 3 * s.triangle;
    const Vec3 a = corner(c);
    return a + s.v * (corner(c + 1) - a) + s.w * (corner(c + 2) - a);
  }
  /// Nearest point of one triangle to p [m].
  [[nodiscard]] BvhHit closest_on(std::int32_t triangle, const Vec3& p) const noexcept;
  /// Nearest point of the mesh within max_distance of p [m]. `seed` is the triangle tested first (-1: none).
  [[nodiscard]] BvhHit closest(const Vec3& p, double max_distance, std::int32_t seed) const noexcept;
};

}  // namespace palpate::scene
