// How a contact force spreads over the surface of a body: by a Gaussian around the contact point. The tool touches the
// surface that the transposed weights give, X + K u, so that what the force does on the body is what the tool feels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::tissue {

/// Sparse weights K of each vertex of a surface, in compressed rows. Each row sums to 1.
class Spreading {
 public:
  Spreading() = default;
  /// vertices: 3n positions at rest [m]; triangles: 3m indices; width: standard deviation of the Gaussian [m].
  /// Integrated with 16 points a triangle, up to 2.8 standard deviations, over triangles that face the same way.
  Spreading(std::span<const double> vertices, std::span<const std::int32_t> triangles, double width);

  /// Weight of one vertex.
  struct Entry {
    std::int32_t vertex;
    double weight;
  };
  [[nodiscard]] std::span<const Entry> row(std::int32_t vertex) const noexcept {
    const auto i = static_cast<std::size_t>(vertex);
    return {&entries_[first_[i]], first_[i + 1] - first_[i]};
  }
  [[nodiscard]] double width() const noexcept { return width_; }
  /// What a half-space of the same elements yields under the load of a triangle's point, times E* = E / (1 - nu^2)
  /// [1/m]. b: barycentric weights of the point. Forces on vertices at a distance r move each other by
  /// 1 / (pi E* r) (Boussinesq), regularised by the length of the edges, with two constants that were found by
  /// comparing layers of 2 to 8 elements with their exact solution.
  [[nodiscard]] double yield(std::int32_t triangle, const double b[3]) const noexcept {
    const double* const y = &yield_[6 * static_cast<std::size_t>(triangle)];
    return b[0] * b[0] * y[0] + b[1] * b[1] * y[1] + b[2] * b[2] * y[2] +
           2.0 * (b[0] * b[1] * y[3] + b[1] * b[2] * y[4] + b[2] * b[0] * y[5]);
  }
  /// The same where a Gaussian of the standard deviation `wider` [m] spreads the load before. edge: mean length of the
  /// edges [m].
  [[nodiscard]] static double widened(double yield, double edge, double wider) noexcept;

 private:
  void find_yields(std::span<const double> vertices, std::span<const std::int32_t> triangles);

  std::vector<std::size_t> first_;
  std::vector<Entry> entries_;
  std::vector<double> yield_;  // (6m) of the corners of each triangle with themselves, and of 01, 12, 20 [1/m]
  double width_ = 0.0;
};

}  // namespace palpate::tissue
