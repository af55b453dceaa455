// A signed distance sampled on a regular grid. Between the nodes the distance is tricubic: continuously differentiable,
// with the exact gradient of the interpolation.
//
// The solid is where the values are negative. It ends at the boundary of the grid, so that a patch cut out of an organ
// is closed by flat sides. Outside the grid the distance is sqrt(d^2 + phi(c)^2), where c is the nearest point of the
// grid, d the distance to c and phi(c) the distance at c, at least 0. It is continuous and never more than the true
// distance, because the grid is convex.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "palpate/scene/surface.hpp"

namespace palpate::scene {

/// Samples the signed distance of a mesh at origin + (i, j, k) * spacing, with k fastest [m]. The size of `values` is
/// the number of nodes.
void sample(const Mesh& mesh, const Vec3& origin, const Vec3& spacing, const std::array<std::size_t, 3>& nodes,
            std::span<float> values) noexcept;

/// Surface at the zero level of a sampled signed distance. All vectors are expressed in the surface's frame O.
class DistanceGrid final : public Surface {
 public:
  /// values: signed distances at origin + (i, j, k) * spacing, with k fastest [m]. There must be at least four nodes
  /// along each axis. Throws std::invalid_argument with the reason: wrong sizes or spacing, a value that is not finite,
  /// no surface inside the grid, or values that grow faster than a distance can.
  DistanceGrid(const Vec3& origin, const Vec3& spacing, const std::array<std::size_t, 3>& nodes,
               std::span<const float> values);

  /// Point of the zero level near p, found along the gradient. Near a ridge of the distance (two walls equally near) it
  /// is the nearest of the surrounding walls.
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  /// Interpolated distance [m] and its gradient [-] at p, which is clamped to the grid.
  double value(const Vec3& p, Vec3& gradient) const noexcept;

  /// The value at node (i, j, k) is values()[i * strides()[0] + j * strides()[1] + k] [m].
  [[nodiscard]] const float* values() const noexcept { return &value_[strides()[0] + strides()[1] + 1]; }
  /// Strides of values() along the first and the second axis.
  [[nodiscard]] std::array<std::size_t, 2> strides() const noexcept { return {padded_[1] * padded_[2], padded_[2]}; }
  /// Number of nodes along each axis.
  [[nodiscard]] const std::array<std::size_t, 3>& nodes() const noexcept { return nodes_; }
  /// Lowest corner of the grid [m].
  [[nodiscard]] const Vec3& lowest() const noexcept { return lowest_; }
  /// Highest corner of the grid [m].
  [[nodiscard]] const Vec3& highest() const noexcept { return highest_; }

 private:
  /// Foot point: a point q of the zero level [m] with its unit normal n.
  struct Foot {
    Vec3 q = Vec3::Zero(), n = Vec3::Zero();
    bool found = false;
  };

  [[nodiscard]] Foot foot(const Vec3& p, const Vec3& start) const noexcept;
  [[nodiscard]] Vec3 onto_wall(Vec3 q) const noexcept;
  [[nodiscard]] Nearest wall(const Vec3& p) const noexcept;
  void add_border(std::span<const float> values);

  Vec3 lowest_, highest_, spacing_;
  std::array<std::size_t, 3> nodes_, padded_;  // padded_: with one more node on each side
  std::vector<float> value_;                   // values with the border [m]
};

}  // namespace palpate::scene
