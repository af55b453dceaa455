// A smooth curve of cubic pieces: a suture line, a cut, a demonstration.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// A chain of cubic Bezier pieces. `arc_length` is the arc length from the start; its relative error is 1e-9 if each
/// piece bends little, as the pieces made by palpate/scene/guidance/paths.py do.
///
/// The nearest point is the global one and does not depend on earlier queries. A tree of bounding boxes selects the
/// pieces. On a piece all roots of (c(u) - p) . c'(u) = 0 are isolated by the signs of the Bernstein coefficients
/// (Sederberg and Nishita 1990) and refined by Newton's method within a bracket. The nearest point jumps where two
/// points of the curve are equally near. That happens no closer to the curve than its smallest radius of curvature or
/// half the distance to another section of it.
/// Beyond an end the path acts like a point (`dimension` 0).
class Path final : public Geometry {
 public:
  using Controls = std::array<Vec3, 4>;  ///< control points of a piece [m]

  /// pieces: at least one; each begins where the previous one ends, and the first, if closed, where the last one ends.
  /// attitudes: rotations at the ends of the pieces, one more than pieces, interpolated along the arc.
  /// tangential: z of the attitudes is the tangent, also in between.
  /// Throws std::invalid_argument naming the bad value.
  Path(std::vector<Controls> pieces, std::span<const Mat3> attitudes, bool tangential, bool closed);
  [[nodiscard]] bool solid() const noexcept override { return false; }
  [[nodiscard]] double length() const noexcept { return start_.back(); }  ///< [m]

 protected:
  [[nodiscard]] Query query_local(const Pose& X_WT, double, double) const noexcept override;

 private:
  /// A point of the curve (piece and parameter u) and its squared distance [m^2].
  struct Best {
    double distance2, u;
    std::size_t piece;
  };
  struct Box {
    Vec3 lowest, highest;
    [[nodiscard]] double distance2(const Vec3& p) const noexcept {
      return (p - p.cwiseMax(lowest).cwiseMin(highest)).squaredNorm();
    }
  };

  void build_tree();
  void update_nearest(std::size_t piece, const Vec3& p, Best& best) const noexcept;
  [[nodiscard]] Best nearest(const Vec3& p) const noexcept;
  [[nodiscard]] Mat3 attitude(const Best& at, double arc_length, const Vec3& tangent) const noexcept;

  std::vector<Controls> pieces_;
  std::vector<double> start_;  // arc length at the start of each piece, and the whole length [m]
  std::vector<Eigen::Quaterniond> attitude_;
  std::vector<Box> box_;  // a binary tree of bounding boxes: children of i at 2 i + 1 and 2 i + 2, leaves last
  std::size_t leaves_ = 1;
  bool tangential_, closed_;
};

}  // namespace palpate::guidance
