// A signed distance sampled on a regular grid, tricubic between the nodes: once differentiable, its gradient its own.
//
// The solid is where the values are below zero. It ends at the edge of its grid: a patch cut out of an organ is closed
// by flat sides. Outside of the grid the distance is sqrt(d^2 + phi(c)^2) with c the grid's nearest point and d how far
// it is: never more than the true distance (the grid is convex), and continuous.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "palpate/scene/surface.hpp"

namespace palpate::scene {

/// Signed distance of a mesh at origin + (i, j, k) * spacing, k fastest [m]: as many values as nodes.
void sample(const Mesh& mesh, const Vec3& origin, const Vec3& spacing, const std::array<std::size_t, 3>& nodes,
            std::span<float> values) noexcept;

class DistanceGrid final : public Surface {
 public:
  /// Values at origin + (i, j, k) * spacing, k fastest [m]; at least four nodes along each axis.
  /// Throws std::invalid_argument naming what is wrong (sizes, spacing, a value that is not finite, no surface inside,
  /// or values that grow faster than a distance can).
  DistanceGrid(const Vec3& origin, const Vec3& spacing, const std::array<std::size_t, 3>& nodes,
               std::span<const float> values);

  /// The nearest place of the zero level near p, found along the gradient; beside a ridge of the distance (two walls
  /// equally near) the nearer of the walls around it.
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  /// The sampled function and its gradient at p, which is taken to the nearest point of the grid.
  double value(const Vec3& p, Vec3& gradient) const noexcept;

  /// At node (i, j, k): values()[i * strides()[0] + j * strides()[1] + k] [m].
  [[nodiscard]] const float* values() const noexcept { return &value_[strides()[0] + strides()[1] + 1]; }
  [[nodiscard]] std::array<std::size_t, 2> strides() const noexcept { return {padded_[1] * padded_[2], padded_[2]}; }
  [[nodiscard]] const std::array<std::size_t, 3>& nodes() const noexcept { return nodes_; }
  [[nodiscard]] const Vec3& lowest() const noexcept { return lowest_; }
  [[nodiscard]] const Vec3& highest() const noexcept { return highest_; }

 private:
  struct Foot {
    Vec3 q = Vec3::Zero(), n = Vec3::Zero();
    bool found = false;
  };

  [[nodiscard]] Foot foot(const Vec3& p, const Vec3& start) const noexcept;
  [[nodiscard]] Vec3 onto_wall(Vec3 q) const noexcept;
  [[nodiscard]] Nearest wall(const Vec3& p) const noexcept;
  void add_border(std::span<const float> values);

  Vec3 lowest_, highest_, spacing_;
  std::array<std::size_t, 3> nodes_, padded_;  // padded: one more on each side
  std::vector<float> value_;
};

}  // namespace palpate::scene
