// A triangle mesh for contact queries: welded vertices, normals, adjacency and a wide BVH.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpate/scene/surface.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

struct BvhHit;
struct Welded;

/// Feature of the mesh that contains a point.
enum class Feature : std::uint8_t { face, edge, vertex };

/// Nearest point of the mesh to a query point. All vectors are expressed in the surface's frame O.
struct ClosestPoint {
  double distance = 0.0;            ///< unsigned distance [m]
  Vec3 point = Vec3::Zero();        ///< point on the mesh [m]
  Vec3 normal = Vec3::Zero();       ///< outward unit normal of the feature (angle-weighted on edges and vertices)
  int triangle = -1;                ///< row of Mesh::triangles(); -1: none
  Feature feature = Feature::face;  ///< feature that contains the point
};

/// Report on the defects found and repaired while building a mesh.
struct MeshReport {
  std::size_t vertices = 0;        ///< number of vertices after welding
  std::size_t triangles = 0;       ///< number of triangles kept
  std::size_t degenerate = 0;      ///< triangles dropped: a repeated corner, or three collinear corners at a boundary
  std::size_t duplicate = 0;       ///< triangles dropped: the same corners in the same orientation
  std::size_t flat = 0;            ///< triangles kept: three collinear corners that close a gap between other triangles
  std::size_t components = 0;      ///< number of components connected by vertices
  std::size_t boundary_edges = 0;  ///< edges of only one triangle: holes and rims
  std::size_t branching_edges = 0;     ///< edges of three or more triangles
  std::size_t inconsistent_edges = 0;  ///< edges whose two triangles have opposite orientations after the repair
  std::size_t flipped = 0;             ///< triangles flipped because they faced the other way than their neighbours
  std::size_t inverted = 0;            ///< triangles flipped because their closed component was inside out
  bool two_sided = true;       ///< false: a component has only one side (Moebius strip); forces may point inwards there
  bool closed = false;         ///< true: there are no boundary, branching or inconsistent edges
  double volume = 0.0;         ///< volume of the closed components without cavities; 0 when there are none [m^3]
  Vec3 lowest = Vec3::Zero();  ///< lowest corner of the bounding box [m]
  Vec3 highest = Vec3::Zero();  ///< highest corner of the bounding box [m]
};

/// Bytes of an image: some of its own, then those of an array of the mesh.
struct ImagePiece {
  std::vector<std::uint8_t> head;
  std::span<const std::uint8_t> array;
};

/// Bytes at whose multiples the arrays of an image begin.
inline constexpr std::size_t kImageAlignment = 32;

/// Triangle mesh. All vectors are expressed in the surface's frame O.
class Mesh final : public Surface {
 public:
  /// Builds a mesh. vertices: 3n coordinates [m]; triangles: 3m indices, counter-clockwise seen from outside. Equal
  /// vertices are welded, degenerate and repeated triangles are dropped, and triangles with the wrong orientation are
  /// flipped; report() counts them. Throws std::invalid_argument with the reason: no triangles, an index out of range,
  /// a vertex that is not finite, or an extent without precision (extent.hpp).
  static std::shared_ptr<const Mesh> build(std::span<const double> vertices, std::span<const std::int32_t> triangles);
  ~Mesh() override;

  /// Builds the mesh of welded triangles, in whose memory it lives on: the arrays that were welded may be freed before.
  static std::shared_ptr<const Mesh> build(Welded welded);
  /// The mesh and its index as bytes, for a cache on disk: reading them takes a fraction of the time of build().
  [[nodiscard]] std::vector<std::uint8_t> image() const;
  /// The same bytes in pieces: those of the arrays stay where the mesh holds them.
  [[nodiscard]] std::vector<ImagePiece> image_pieces() const;
  /// The mesh of `image()`, whose arrays stay in the bytes: these must outlive it, and nothing may change them. Bytes
  /// that do not begin at a multiple of kImageAlignment are copied. Throws std::invalid_argument if the bytes are
  /// incomplete or an index in them is out of range.
  static std::shared_ptr<const Mesh> from_image(std::span<const std::uint8_t> image);

  /// Number of triangles.
  [[nodiscard]] std::size_t triangle_count() const noexcept;
  /// Defects found and repaired by build().
  [[nodiscard]] const MeshReport& report() const noexcept;
  /// The mesh after the repair: 3 coordinates per vertex [m].
  [[nodiscard]] std::span<const double> vertices() const noexcept;
  /// The mesh after the repair: 3 indices per triangle.
  [[nodiscard]] std::span<const std::int32_t> triangles() const noexcept;
  /// Edges of only one triangle: 2 vertex indices per edge, in the orientation of the triangle.
  [[nodiscard]] std::vector<std::int32_t> rims() const;

  /// A copy of the mesh whose vertices can move.
  [[nodiscard]] std::shared_ptr<Mesh> movable() const;
  /// Moves the vertices, 3 finite coordinates per vertex [m]. Normals and the index follow; adjacency and creases stay.
  /// It does not allocate. Only the thread that uses a movable copy may call it.
  void move(std::span<const double> vertices) noexcept;

  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  /// Same as nearest(p), but faster if the triangle `seed` is near p (-1: none). Sets `seed` to the nearest triangle.
  [[nodiscard]] Nearest nearest(const Vec3& p, int& seed) const noexcept;
  [[nodiscard]] Nearest nearest_or_far(const Vec3& p, double exact_within) const noexcept override;
  [[nodiscard]] const Mesh* mesh() const noexcept override { return this; }
  /// Nearest point within `max_distance` [m]. Its triangle is -1 when no point is that near.
  [[nodiscard]] ClosestPoint closest(const Vec3& p, double max_distance) const noexcept;
  /// Distance that the centre of a sphere can move from `a` towards `b` before the sphere of `radius` touches a
  /// triangle [m]. The distance is at most |b - a| and ends at most a twentieth of the radius before the first contact.
  /// No triangle is jumped over.
  [[nodiscard]] double sweep(const Vec3& a, const Vec3& b, double radius) const noexcept;
  /// True for a point inside a closed mesh (decided by the angle-weighted normal at the nearest point). It is always
  /// false for an open mesh.
  [[nodiscard]] bool contains(const Vec3& p) const noexcept;

  struct Impl;  ///< internal data (mesh_impl.hpp), for stages that walk on the surface
  /// The internal data.
  [[nodiscard]] const Impl& impl() const noexcept { return *impl_; }

 private:
  Mesh();
  [[nodiscard]] ClosestPoint closest(const Vec3& p, double max_distance, int seed) const noexcept;
  [[nodiscard]] ClosestPoint closest_point(const BvhHit& hit) const noexcept;
  [[nodiscard]] Nearest sided(const Vec3& p, const ClosestPoint& c) const noexcept;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::scene
