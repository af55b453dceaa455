// A triangle mesh ready to be touched: welded vertices, normals, adjacency and a wide BVH over them.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::scene {

enum class Feature : std::uint8_t { face, edge, vertex };

/// Nearest point of the surface to a query point.
struct ClosestPoint {
  double distance = 0.0;  ///< unsigned [m]
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< outward normal of the feature (angle-weighted on edges and vertices)
  int triangle = -1;
  Feature feature = Feature::face;
};

class Mesh {
 public:
  /// vertices: 3n doubles [m], triangles: 3m indices, counter-clockwise seen from outside.
  /// Throws std::invalid_argument naming what is wrong (no triangles, index out of range, not finite).
  static std::shared_ptr<const Mesh> build(std::span<const double> vertices, std::span<const std::int32_t> triangles);
  ~Mesh();
  Mesh(const Mesh&) = delete;
  Mesh& operator=(const Mesh&) = delete;

  [[nodiscard]] std::size_t triangle_count() const noexcept;
  /// Nearest point within `max_distance`; triangle = -1 when there is none.
  [[nodiscard]] ClosestPoint closest(const Vec3& p, double max_distance) const noexcept;

  struct Impl;
  [[nodiscard]] const Impl& impl() const noexcept { return *impl_; }

 private:
  Mesh();
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::scene
