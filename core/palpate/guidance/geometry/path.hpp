// A smooth curve of cubic pieces: a suture line, a cut, a demonstration.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "palpate/guidance/geometry.hpp"

namespace palpate::guidance {

/// Of cubic Bezier pieces one after the other. `along` is the arc length from the start, to 1e-9 of it when pieces turn
/// by little (palpate/guidance/path.py makes them so).
///
/// The nearest place is the nearest of all, found without a memory: pieces by a tree of their boxes, then on a piece
/// every root of (c(u) - p) c'(u) = 0, isolated by the signs of its Bernstein coefficients (Sederberg and Nishita 1990)
/// and closed in on by Newton's method in a bracket. It jumps where two places are equally near: no nearer to the curve
/// than its smallest radius of curvature, or half of the gap to another stretch of it.
/// Beyond an end the path is a point (`dimension` 0).
class Path final : public Geometry {
 public:
  using Controls = std::array<Vec3, 4>;

  /// pieces: at least one, each beginning where the last ended; closed: and the first where the last ends.
  /// attitudes: R at the pieces' ends, one more than pieces, turned into each other along the arc; tangential: their z
  /// is the tangent, kept so in between. Throws std::invalid_argument naming what is wrong.
  Path(std::vector<Controls> pieces, std::span<const Mat3> attitudes, bool tangential, bool closed);
  [[nodiscard]] bool solid() const noexcept override { return false; }
  [[nodiscard]] double length() const noexcept { return start_.back(); }  ///< [m]

 protected:
  [[nodiscard]] Query answer(const Pose& X_WT, double) const noexcept override;

 private:
  /// Squared distance to a place of the curve.
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
  void look_at(std::size_t piece, const Vec3& p, Best& best) const noexcept;
  [[nodiscard]] Best nearest(const Vec3& p) const noexcept;
  [[nodiscard]] Mat3 attitude(const Best& at, double along, const Vec3& tangent) const noexcept;

  std::vector<Controls> pieces_;
  std::vector<double> start_;  // arc length where each piece begins, and the whole [m]
  std::vector<Eigen::Quaterniond> attitude_;
  std::vector<Box> box_;  // a binary tree: children of i at 2 i + 1 and 2 i + 2, the leaves last
  std::size_t leaves_ = 1;
  bool tangential_, closed_;
};

}  // namespace palpate::guidance
