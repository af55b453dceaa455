// The inside of a mesh, for stages that stay on its surface from tick to tick.
#pragma once

#include <vector>

#include "palpate/scene/bvh.hpp"
#include "palpate/scene/mesh.hpp"
#include "palpate/scene/topology.hpp"

namespace palpate::scene {

/// A point of the surface: corner 0 + v (corner 1 - corner 0) + w (corner 2 - corner 0) of a (welded) triangle.
struct SurfacePoint {
  std::int32_t triangle = -1;
  double v = 0.0;
  double w = 0.0;

  [[nodiscard]] double u() const noexcept { return 1.0 - v - w; }
};

struct Mesh::Impl {
  std::vector<double> vertices;
  std::vector<std::int32_t> triangles;
  Topology topology;
  Bvh bvh;
  MeshReport report;

  [[nodiscard]] Vec3 corner(std::int32_t half_edge) const noexcept {
    return Vec3(&vertices[3 * static_cast<std::size_t>(triangles[static_cast<std::size_t>(half_edge)])]);
  }
  [[nodiscard]] Vec3 normal(std::int32_t half_edge) const noexcept {
    return Vec3(&topology.normals[3 * static_cast<std::size_t>(topology.normal[static_cast<std::size_t>(half_edge)])]);
  }
  [[nodiscard]] Vec3 position(const SurfacePoint& s) const noexcept {
    const std::int32_t c = 3 * s.triangle;
    const Vec3 a = corner(c);
    return a + s.v * (corner(c + 1) - a) + s.w * (corner(c + 2) - a);
  }
  /// Nearest point of one triangle.
  [[nodiscard]] BvhHit closest_on(std::int32_t triangle, const Vec3& p) const noexcept;
  /// Nearest point within max_distance, looking at triangle `seed` first (-1: none).
  [[nodiscard]] BvhHit closest(const Vec3& p, double max_distance, std::int32_t seed) const noexcept;
};

}  // namespace palpate::scene
