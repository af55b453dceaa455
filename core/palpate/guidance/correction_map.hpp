// How a corrected goal moves with the mapped goal: the Jacobian with which forces on the tool are carried back to the
// hand (NOTATION.md, "Virtual work"), and the gradients of the fixtures' shares in the correction.
//
// The correction y = displacement from the mapped goal X_m to the corrected goal X_c satisfies
//
//   y = sum of lambda_i a_i(X_c)      gap_i(X_c) = -allowed_i      for the active rows i
//
// The derivative of these equations, with the curvature H_i = d a_i / d X_c of each border, is a linear system for
// d X_c and d lambda. For a plane it yields the projection I - a a^T, and for a ball of radius R entered by d the
// factor R / (R - d) along its surface.
#pragma once

#include <array>

#include "palpate/guidance/constraint.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// An active row of the program that corrects the goal. Vectors and matrices are those of (displacement, kLength *
/// rotation), as in row().
struct ActiveRow {
  int fixture = -1;           ///< fixture of the row; -1 for a joint limit
  double lambda = 0.0;        ///< multiplier, above zero
  Vec6 a = Vec6::Zero();      ///< direction in which the row moves the goal
  Vec6 g = Vec6::Zero();      ///< gradient of the gap at the corrected goal
  Mat6 H = Mat6::Zero();      ///< derivative of a with respect to the corrected goal [1/m]
  Vec6 plain = Vec6::Zero();  ///< a and lambda of the program, before the curvature of the border is known
  double plain_lambda = 0.0;
  bool turns = false;     ///< the gap depends on the rotation
  bool by_force = false;  ///< the row limits the touched force, which the hand goes on feeling: not part of J
  Vec6 b = Vec6::Zero();  ///< derivative of the row's bound with respect to the mapped goal: authority below one
};

/// The map from the mapped to the corrected goal, linearised.
class CorrectionMap {
 public:
  static constexpr int kRows = 6;  ///< largest number of active rows

  /// Removes all rows; the map is the identity.
  void clear() noexcept;
  /// Adds a row; false if there are kRows already.
  bool add(const ActiveRow& row) noexcept;
  [[nodiscard]] int rows() const noexcept { return rows_; }
  [[nodiscard]] ActiveRow& row(int r) noexcept { return row_[static_cast<std::size_t>(r)]; }
  [[nodiscard]] const ActiveRow& row(int r) const noexcept { return row_[static_cast<std::size_t>(r)]; }

  /// The corrected goal stays in place, whatever the mapped goal does.
  void hold() noexcept { P_.setZero(); }
  /// Solves for the derivatives. y: the correction. Where the corrected goal is no minimum of the distance (it is on
  /// its way to another place) or rows depend on each other, the borders count as flat.
  void solve(const Vec6& y) noexcept;

  /// Derivative of the corrected goal with respect to the mapped goal; both as (displacement, rotation vector) in W.
  [[nodiscard]] Mat6 jacobian() const noexcept;
  /// The share of a fixture in the correction [m, or rad for a rotational constraint], corrected for rows that are not
  /// orthogonal, and minus its gradient with respect to the mapped goal, in W. Where the gap depends on the rotation,
  /// the row of the program stands for the gradient: exact to first order of the correction.
  struct Share {
    double size = 0.0;
    Wrench direction;
  };
  [[nodiscard]] Share share(int fixture) const noexcept;

 private:
  /// The part v of the correction that one fixture causes: its length, the length of its rows, and their derivatives
  /// with respect to the mapped goal.
  struct Part {
    double length = 0.0, stretch = 0.0;
    Vec6 d_length = Vec6::Zero(), d_stretch = Vec6::Zero();
  };

  bool try_solve(const Vec6& y, bool curved) noexcept;
  [[nodiscard]] bool begins_part(int r) const noexcept;
  [[nodiscard]] Part part_of(int r) const noexcept;

  int rows_ = 0;
  std::array<ActiveRow, kRows> row_;
  bool curved_ = false;                 ///< the last solution accounts for the curvature
  Mat6 P_ = Mat6::Identity();           ///< d X_c / d X_m
  Eigen::Matrix<double, kRows, 6> dl_;  ///< d lambda / d X_m
  double size_ = 0.0;                   ///< |y|
  double parts_ = 0.0;                  ///< root of the sum of squares of the fixtures' parts of y
  Vec6 d_size_ = Vec6::Zero();          ///< d |y| / d X_m
  Vec6 d_parts_ = Vec6::Zero();         ///< d parts / d X_m
};

}  // namespace palpate::guidance
