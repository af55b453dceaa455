// An 8-wide bounding volume hierarchy (BVH) over triangles, for nearest-point queries at haptic rates.
//
// Bounding volumes are in single precision, rounded outwards, in coordinates that are centred on the mesh and scaled to
// [-1, 1]. The precision therefore does not depend on the size and position of the mesh. Triangles are in double
// precision, in blocks of four for the SIMD kernels. This header does not use Eigen, because it is included by files
// that are compiled for wider instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

namespace palpate::scene {

/// Node with eight children. Each child is bounded by a box and by a thick disc, which is tight around an oblique patch
/// of surface, where a box is loose. child >= 0: index of a node; child < 0: triangle block ~child. Unused children
/// have empty boxes.
struct alignas(32) BvhNode {
  float lo[3][8];         ///< lower corners of the boxes
  float hi[3][8];         ///< upper corners of the boxes
  float centre[3][8];     ///< centres of the discs
  float normal[3][8];     ///< normals of the discs, of length 1 or less; zero: the disc is a ball
  float radius[8];        ///< radii of the discs; infinity: no disc
  float half[8];          ///< half the thicknesses of the discs
  std::int32_t child[8];  ///< nodes or triangle blocks
};

inline constexpr std::size_t kTrianglesPerBlock = 4;

/// Largest number of nodes between the root and a block, both ends counted. It bounds the stack of a query.
inline constexpr int kBvhLevels = 42;

/// Four triangles (a, a + e1, a + e2) [m]. A leaf with fewer triangles repeats its last one.
struct alignas(32) TriangleBlock {
  double a[3][4];   ///< corner 0 of each triangle
  double e1[3][4];  ///< edges from corner 0 to corner 1
  double e2[3][4];  ///< edges from corner 0 to corner 2
};

/// The hierarchy, made by build_bvh(). Its arrays may lie in a stored image, where nothing writes to them.
struct Bvh {
  std::size_t node_count = 0;               ///< number of nodes
  std::size_t block_count = 0;              ///< number of triangle blocks
  std::shared_ptr<BvhNode[]> nodes;         ///< nodes[0] is the root
  std::shared_ptr<TriangleBlock[]> blocks;  ///< triangles of the leaves
  std::shared_ptr<std::int32_t[]> ids;      ///< indices of the triangles, four for each block
  double centre[3] = {0, 0, 0};             ///< centre of the mesh's bounding box [m]
  double scale = 1.0;  ///< (p - centre) * scale is in [-1, 1]^3 for points of the mesh; a power of two [1/m]
};

/// Nearest point a + v e1 + w e2 on a triangle. On edges and corners the weights of the other corners are exactly 0,
/// except that 1 - v - w may have a rounding error.
struct BvhHit {
  double distance2 = 0.0;      ///< squared distance [m^2]
  double v = 0.0;              ///< barycentric weight of corner 1 [-]
  double w = 0.0;              ///< barycentric weight of corner 2 [-]
  std::int32_t triangle = -1;  ///< index of the triangle, -1: none
};

/// Distance within which a query is exact: everywhere [m].
inline constexpr double kExact = std::numeric_limits<double>::infinity();
/// Fraction of a distance that a quicker search beyond `exact_within` guarantees.
inline constexpr double kFar = 15.0 / 16.0;

/// Builds the hierarchy, on up to two threads. vertices: 3n finite coordinates [m]; triangles: 3m indices of vertices,
/// m >= 1.
Bvh build_bvh(std::span<const double> vertices, std::span<const std::int32_t> triangles);

/// Nearest point on a triangle closer than sqrt(best.distance2) to p [m]. Returns `best` itself if no triangle is
/// closer. The query does not allocate.
///
/// A point farther than `exact_within` [m] may be found by a quicker search: then no triangle is nearer to p than
/// far_bound(its distance, exact_within). In the middle of a round cavity, where all triangles are almost equally near,
/// the exact search would have to visit each of them.
BvhHit bvh_closest(const Bvh& bvh, const double p[3], const BvhHit& best, double exact_within = kExact) noexcept;

/// Lower bound of the distance to the mesh where a search with `exact_within` found a point at `distance` [m].
inline double far_bound(double distance, double exact_within) noexcept {
  if (distance <= exact_within) return distance;
  return kFar * distance > exact_within ? kFar * distance : exact_within;
}

/// The kernels of bvh_closest(), declared here so that tests can compare them.
BvhHit bvh_closest_avx2(const Bvh& bvh, const double p[3], const BvhHit& best, double exact_within = kExact) noexcept;
BvhHit bvh_closest_portable(const Bvh& bvh, const double p[3], const BvhHit& best,
                            double exact_within = kExact) noexcept;
/// True if this processor supports AVX2 and FMA.
bool bvh_has_avx2() noexcept;

}  // namespace palpate::scene
