// Averaged points with normals, sorted by the cells of a regular grid for searches within a radius.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::clouds {

/// A point of the surface, the mean of the points in one voxel.
struct alignas(16) GridPoint {
  float p[3];     ///< position relative to PointGrid::origin() [m]
  float weight;   ///< number of averaged points, at most 255 [-]
  float n[3];     ///< outward unit normal
  float padding;  ///< 0: four numbers are added at once
};

/// The points, in cells of a regular grid.
class PointGrid {
 public:
  /// Averages the points in each voxel. points: 3n coordinates [m]; normals: 3n components or empty. viewpoint orients
  /// normals that are unknown, which are those of the planes through the neighbours within `reach` [m]. Points with
  /// fewer than five neighbours, and those seen at a grazing angle, are left out as flying pixels.
  PointGrid(std::span<const double> points, std::span<const double> normals, const std::optional<Vec3>& viewpoint,
            double voxel, double reach);

  [[nodiscard]] const std::vector<GridPoint>& points() const noexcept { return points_; }
  [[nodiscard]] const Vec3& origin() const noexcept { return origin_; }
  /// Number of points left out as flying pixels.
  [[nodiscard]] std::size_t rejected() const noexcept { return rejected_; }
  void translate(const Vec3& d) noexcept { origin_ += d; }
  void set_rejected(std::size_t n) noexcept { rejected_ = n; }

  /// Calls visit(point, index) for all points in the cells that the ball around q touches. q: relative to origin() [m].
  template <typename Visit>
  void visit_near(const Vec3& q, double radius, const Visit& visit) const noexcept {
    const double radius2 = radius * radius;
    for (int z = cell(q[2] - radius, 2), z_end = cell(q[2] + radius, 2); z <= z_end; ++z) {
      const double left = radius2 - gap2(q[2], z);
      for (int y = cell(q[1] - radius, 1), y_end = cell(q[1] + radius, 1); y <= y_end; ++y) {
        const double x2 = left - gap2(q[1], y);
        if (x2 < 0.0) continue;
        const double x = std::sqrt(x2);
        const std::size_t row = (static_cast<std::size_t>(z) * size_[1] + static_cast<std::size_t>(y)) * size_[0];
        const std::uint32_t end = start_[row + static_cast<std::size_t>(cell(q[0] + x, 0)) + 1];
        for (std::uint32_t i = start_[row + static_cast<std::size_t>(cell(q[0] - x, 0))]; i < end; ++i)
          visit(points_[i], i);
      }
    }
  }

 private:
  [[nodiscard]] int cell(double x, int axis) const noexcept {
    const double i = x * per_cell_;
    const double last = static_cast<double>(size_[axis]) - 1.0;
    return static_cast<int>(i < 0.0 ? 0.0 : i > last ? last : i);
  }
  /// Squared distance of a coordinate from a cell [m^2].
  [[nodiscard]] double gap2(double x, int cell) const noexcept {
    const double i = x * per_cell_ - cell, gap = (i < 0.0 ? -i : i > 1.0 ? i - 1.0 : 0.0) / per_cell_;
    return gap * gap;
  }
  void sort(double reach);
  void estimate_normals(const std::optional<Vec3>& viewpoint, double reach);

  std::vector<GridPoint> points_;
  Vec3 origin_ = Vec3::Zero();  // lower corner of the grid [m]
  double per_cell_ = 1.0;       // cells per metre
  std::size_t size_[3] = {1, 1, 1};
  std::vector<std::uint32_t> start_;  // index of the first point of each cell, and the number of points
  std::size_t rejected_ = 0;
};

}  // namespace palpate::clouds
