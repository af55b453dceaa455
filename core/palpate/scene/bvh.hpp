// An 8-wide bounding volume hierarchy over triangles, for nearest-point queries at haptic rates.
//
// Boxes are single precision, rounded outwards, in coordinates centred on the mesh and scaled to [-1, 1], so that
// nothing depends on the mesh's size or place. Triangles are double precision, four to a block, as the kernels
// want them. No Eigen here: these headers are seen by files compiled for wider instruction sets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace palpate::scene {

/// Eight children, each within a box and within a thick disc: a box alone is loose around a patch of surface that lies
/// aslant. child >= 0: a node; child < 0: the triangle block ~child. Unused children have empty boxes.
struct alignas(32) BvhNode {
  float lo[3][8];
  float hi[3][8];
  float centre[3][8];  ///< of the disc
  float normal[3][8];  ///< at most a unit long; zero: the disc is a ball
  float radius[8];     ///< across the normal; infinity: no disc
  float half[8];       ///< of the thickness, along the normal
  std::int32_t child[8];
};

inline constexpr std::size_t kTrianglesPerBlock = 4;

/// Four triangles (a, a + e1, a + e2); a leaf with fewer repeats its last one.
struct alignas(32) TriangleBlock {
  double a[3][4];
  double e1[3][4];
  double e2[3][4];
};

struct Bvh {
  std::size_t node_count = 0;
  std::size_t block_count = 0;
  std::unique_ptr<BvhNode[]> nodes;  ///< nodes[0] is the root
  std::unique_ptr<TriangleBlock[]> blocks;
  std::unique_ptr<std::int32_t[]> ids;  ///< of the triangles, four for each block
  double centre[3] = {0, 0, 0};         ///< of the mesh's box
  double scale = 1.0;                   ///< (p - centre) * scale is in [-1, 1]^3 on the mesh; a power of two
};

/// Nearest point a + v e1 + w e2 on triangle `triangle`; v, w are exactly on the simplex's rim on edges and corners.
struct BvhHit {
  double distance2 = 0.0;
  double v = 0.0;
  double w = 0.0;
  std::int32_t triangle = -1;
};

/// vertices: 3n doubles, finite; triangles: 3m indices into them, m >= 1. Uses up to two threads.
Bvh build_bvh(std::span<const double> vertices, std::span<const std::int32_t> triangles);

/// Nearest triangle closer than sqrt(best.distance2); returns `best` itself when there is none. Allocation free.
BvhHit bvh_closest(const Bvh& bvh, const double p[3], const BvhHit& best) noexcept;

/// The kernels behind bvh_closest, by name, so that tests can hold them against each other.
BvhHit bvh_closest_avx2(const Bvh& bvh, const double p[3], const BvhHit& best) noexcept;
BvhHit bvh_closest_portable(const Bvh& bvh, const double p[3], const BvhHit& best) noexcept;
bool bvh_has_avx2() noexcept;

}  // namespace palpate::scene
