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

 private:
  std::vector<std::size_t> first_;
  std::vector<Entry> entries_;
  double width_ = 0.0;
};

/// Mean over two Gaussian loads of the displacement of an elastic half-space by one of them, times E* = E / (1 - nu^2)
/// [1/m]. width: standard deviation of each [m]; apart: distance of their centres [m]. At the distance r, a point force
/// F moves the surface by F / (pi E* r) (Boussinesq).
[[nodiscard]] double mutual_yield(double width, double apart) noexcept;

}  // namespace palpate::tissue
