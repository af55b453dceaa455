// The part of a surface under a sphere, and how deep the sphere is in it as a whole.
//
// A point of the surface lies below the tool's surface by s_q along the axis of the contact, the mean normal of the
// patch. Sample points with areas A_q, projected along the axis, make the sum S = sum A_q exp(s_q / T). The depth of
// the contact is
//
//   D = T ln(S / S_0),   T = kSoftness R,   S_0 = 2 pi T (R - T),
//
// which is the depth of the sphere where the surface is flat. D is smooth in the centre and in all points, also where
// the sphere fills its dent and many points are equally near. The energy V(D) gives forces along the normals of the
// surface, which share themselves out over the points and are exactly opposite on sphere and surface. On a flat surface
// their profile is a Gaussian of the standard deviation sqrt(R T). Where the sphere is steep, a cone continues it, and
// the weight of points beside it ends softly.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "palpate/tissue/soft_tables.hpp"

namespace palpate::tissue {

inline constexpr int kPatchTriangles = 384, kPatchVertices = 256, kPatchPoints = 512;
inline constexpr double kSoftness = 0.09;  ///< T / R; less makes the contact stiffer against its own dent

/// Depth of a sphere in a patch, with its derivatives.
struct Meeting {
  double depth = 0.0;        ///< D; zero or less: no contact [m]
  double yield = 0.0;        ///< mean of Spreading::yield over the points [1/m]
  Vec3 push = Vec3::Zero();  ///< -dD/dc: the force on the sphere over V'(D) [-]
};

/// Triangles under a sphere with their sample points.
class Patch {
 public:
  /// Collects the triangles around the sphere on the side of the surface that faces along `out`. mesh: the surface as
  /// it is; starts: triangles from which the search begins, -1: none; the first one is always a part; seen: one number
  /// a triangle, with values up to `round` - 1.
  void gather(const SoftTables& tables, const scene::Mesh::Impl& mesh, const Vec3& centre, double radius,
              const Vec3& out, std::span<const std::int32_t> starts, std::vector<std::uint32_t>& seen,
              std::uint32_t round) noexcept;

  /// Lets the directions of the forces turn with the triangles: for a surface that moves on before the next gather().
  void turn_with_triangles() noexcept { turns_ = true; }

  /// Depth of the sphere with its centre at c [m]. x: positions of the vertices() [m]. pull: (vertices()) result: the
  /// derivatives dD/dx, whose sum is `push` [-]; share: (vertices()) result: weights of the vertices, sum 1.
  [[nodiscard]] Meeting meet(const SoftTables& tables, const Vec3& centre, const Vec3* x, Vec3* pull,
                             double* share) const noexcept;

  /// Triangle whose corners carry the largest share, from which the search of the next tick begins; -1: none.
  [[nodiscard]] std::int32_t heaviest(const double* share) const noexcept;
  [[nodiscard]] int vertices() const noexcept { return vertices_; }
  [[nodiscard]] std::int32_t vertex(int i) const noexcept { return vertex_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] std::span<const std::int32_t> all() const noexcept {
    return {vertex_.data(), static_cast<std::size_t>(vertices_)};
  }
  [[nodiscard]] const Vec3& axis() const noexcept { return axis_; }

  Patch() = default;
  Patch(const Patch& other) noexcept { *this = other; }
  /// Copies the used entries.
  Patch& operator=(const Patch& other) noexcept;

 private:
  struct Triangle {
    std::int32_t index = -1;                ///< of the mesh
    std::array<std::uint16_t, 3> corner{};  ///< entries of vertex_
    Vec3 slope = Vec3::Zero();              ///< its normal n over n . axis, as it was collected
  };
  struct Point {
    std::uint16_t triangle = 0, place = 0;            ///< place: of the subdivision
    float height = 0.0F;                              ///< of the smooth surface over the facet [m]
    Eigen::Vector3f slope = Eigen::Vector3f::Zero();  ///< smooth normal n over n . axis: the force over its axial part
  };

  bool add_triangle(const SoftTables& tables, std::int32_t t) noexcept;
  void find_axis(const scene::Mesh::Impl& mesh, const Vec3& centre, double around, const Vec3& out) noexcept;
  [[nodiscard]] Vec3 slope_of(const Vec3& normal) const noexcept;
  void add_points(const SoftTables& tables, const scene::Mesh::Impl& mesh, const Vec3& centre) noexcept;

  Vec3 axis_ = Vec3::UnitZ();
  double radius_ = 0.0;
  bool turns_ = false;
  int divisions_ = 1, triangles_ = 0, vertices_ = 0, points_ = 0;
  std::array<Triangle, kPatchTriangles> triangle_;
  std::array<std::int32_t, kPatchVertices> vertex_{};
  std::array<Point, kPatchPoints> point_;
};

}  // namespace palpate::tissue
