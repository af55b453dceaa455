// A triangle mesh ready to be touched: welded vertices, normals, adjacency and a wide BVH over them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpate/scene/surface.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

enum class Feature : std::uint8_t { face, edge, vertex };

/// Nearest point of the surface to a query point.
struct ClosestPoint {
  double distance = 0.0;  ///< unsigned [m]
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::Zero();  ///< outward normal of the feature (angle-weighted on edges and vertices)
  int triangle = -1;           ///< row of Mesh::triangles()
  Feature feature = Feature::face;
};

/// What was found and done while a mesh was built.
struct MeshReport {
  std::size_t vertices = 0;            ///< after welding
  std::size_t triangles = 0;           ///< kept
  std::size_t degenerate = 0;          ///< dropped: a corner repeated, or three on a line at a rim
  std::size_t duplicate = 0;           ///< dropped: the same corners in the same turn
  std::size_t flat = 0;                ///< kept: three corners on a line that close a gap between others
  std::size_t parts = 0;               ///< connected by vertices
  std::size_t boundary_edges = 0;      ///< of one triangle only: holes and rims
  std::size_t branching_edges = 0;     ///< of three triangles or more
  std::size_t inconsistent_edges = 0;  ///< whose two triangles are wound against each other, though all was tried
  std::size_t turned = 0;              ///< triangles that faced the other way than their neighbours: turned
  std::size_t inverted = 0;            ///< triangles of closed parts that were inside out: turned
  bool two_sided = true;               ///< false: a part is a Moebius strip or alike; forces may point inwards there
  bool closed = false;                 ///< no boundary, branching or inconsistent edges
  double volume = 0.0;                 ///< of the closed parts, cavities taken off; 0 when there are none [m^3]
  Vec3 lowest = Vec3::Zero();          ///< corner of the bounding box [m]
  Vec3 highest = Vec3::Zero();
};

class Mesh final : public Surface {
 public:
  /// vertices: 3n doubles [m], triangles: 3m indices, counter-clockwise seen from outside. A soup is welded, triangles
  /// without a surface and repeated ones are dropped, those that face the wrong way are turned; the report counts them.
  /// Throws std::invalid_argument naming what is wrong: no triangles, an index out of range, a vertex that is not
  /// finite, extents without precision (extent.hpp).
  static std::shared_ptr<const Mesh> build(std::span<const double> vertices, std::span<const std::int32_t> triangles);
  ~Mesh() override;

  /// The mesh and its index as bytes, for a cache on disk: reading them takes a fraction of the time of build().
  [[nodiscard]] std::vector<std::byte> image() const;
  /// The mesh of `image()`. Throws std::invalid_argument if the bytes are incomplete or an index in them is out of range.
  static std::shared_ptr<const Mesh> from_image(std::span<const std::byte> image);

  [[nodiscard]] std::size_t triangle_count() const noexcept;
  [[nodiscard]] const MeshReport& report() const noexcept;
  /// The mesh in use: 3 doubles a vertex, 3 indices a triangle.
  [[nodiscard]] std::span<const double> vertices() const noexcept;
  [[nodiscard]] std::span<const std::int32_t> triangles() const noexcept;
  /// Edges of one triangle only, from vertex to vertex in the triangle's turn: 2 indices an edge.
  [[nodiscard]] std::vector<std::int32_t> rims() const;

  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  /// The same answer, sooner where `seed` (a triangle, or -1) is near: it is looked at first, and becomes the nearest.
  [[nodiscard]] Nearest nearest(const Vec3& p, int& seed) const noexcept;
  [[nodiscard]] const Mesh* mesh() const noexcept override { return this; }
  /// Nearest point within `max_distance`; triangle = -1 when there is none.
  [[nodiscard]] ClosestPoint closest(const Vec3& p, double max_distance) const noexcept;
  /// How far a sphere's centre may go from `a` towards `b` before a triangle comes nearer than `radius` to it:
  /// at most |b - a|, short of the first hit by at most a twentieth of the radius. Nothing is jumped over.
  [[nodiscard]] double sweep(const Vec3& a, const Vec3& b, double radius) const noexcept;
  /// Inside of a closed mesh (by the angle-weighted normal at the nearest point); false for open ones.
  [[nodiscard]] bool contains(const Vec3& p) const noexcept;

  struct Impl;  ///< mesh_impl.hpp, for the stages that walk on the surface
  [[nodiscard]] const Impl& impl() const noexcept { return *impl_; }

 private:
  Mesh();
  [[nodiscard]] ClosestPoint closest(const Vec3& p, double max_distance, int seed) const noexcept;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::scene
