// The quadratic program of guidance: the point nearest to y0 in the intersection of half-spaces.
//
//   min |y - y0|^2 / 2    subject to    a_i . y >= b_i,   i = 1..m
//
// Solved by the dual active-set method of Goldfarb and Idnani (1983) for a unit Hessian: starting at y0, the method
// adds one violated row after the other, and each intermediate point is optimal for the rows added so far. It allocates
// nothing, and the number of steps is bounded. If the steps do not suffice because many rows contradict each other, the
// sum of squared violations is minimised instead, with weights that differ by 10^4 between ranks. docs/guidance-hard.md
// compares the solver with others.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// The quadratic program and its solver.
class Qp {
 public:
  static constexpr int kVars = 6;             ///< variables
  static constexpr int kRows = 544;           ///< largest number of rows
  static constexpr int kSteps = 120;          ///< largest number of steps, which add or drop a row
  static constexpr double kTolerance = 1e-9;  ///< violation of a row accepted as satisfied [units of y]

  enum class Status {
    solved,   ///< every row is satisfied
    relaxed,  ///< rows contradict each other: rows of the lowest rank were dropped, all others are satisfied
    stopped,  ///< the steps were used up: y minimises the sum of squared violations, weighted by rank
  };

  /// Removes all rows.
  void clear() noexcept { m_ = 0; }
  /// Removes the rows from index m on.
  void truncate(int m) noexcept { m_ = m; }
  /// Adds the row a . y >= b. Among rows that contradict each other the one of the lowest rank is dropped; among
  /// equal ranks the one that was last to become active (the most violated row does so first). Returns the index of
  /// the row; -1 if it is not finite, if a = 0, or if the program is full.
  int add(const Vec6& a, double b, int rank = 0) noexcept;
  /// Copies row `from` to row `to`.
  void move(int from, int to) noexcept;
  [[nodiscard]] int rows() const noexcept { return m_; }

  /// Solves the program for a finite y0. Rows that were active in the last solution are tried first (warm start).
  Status solve(const Vec6& y0) noexcept;
  /// The solution of the last solve().
  [[nodiscard]] const Vec6& y() const noexcept { return now_.y; }
  /// Lagrange multiplier of row i, never negative: y - y0 = sum of multiplier_i a_i.
  [[nodiscard]] double multiplier(int i) const noexcept { return lambda_[static_cast<std::size_t>(i)]; }
  /// True if row i was dropped because it contradicts other rows.
  [[nodiscard]] bool dropped(int i) const noexcept { return out_[static_cast<std::size_t>(i)]; }
  /// a_i as given to add().
  [[nodiscard]] Vec6 row(int i) const noexcept { return length(i) * a_[static_cast<std::size_t>(i)]; }
  /// a_i . y - b_i at the solution.
  [[nodiscard]] double slack(int i) const noexcept;
  /// True if y satisfies the first `rows` rows within kTolerance.
  [[nodiscard]] bool satisfies(const Vec6& y, int rows) const noexcept;
  /// Number of steps of the last solve().
  [[nodiscard]] int steps() const noexcept { return steps_; }

 private:
  /// The optimum for a set of active rows.
  struct State {
    Vec6 y = Vec6::Zero();
    int q = 0;                          ///< number of active rows
    std::array<int, kVars> set{};       ///< indices of the active rows
    std::array<double, kVars + 1> u{};  ///< multipliers of the active unit rows, then that of the row being added
  };

  [[nodiscard]] int most_violated() const noexcept;
  bool add_active(int p) noexcept;
  void factorise() noexcept;
  void drop(int k) noexcept;
  void drop_contradicting(int p, const Vec6& r) noexcept;
  void least_violation() noexcept;
  [[nodiscard]] double length(int i) const noexcept { return length_[static_cast<std::size_t>(i)]; }

  int m_ = 0, steps_ = 0;
  std::array<Vec6, kRows> a_;  ///< scaled to unit length
  std::array<double, kRows> b_{}, length_{}, lambda_{};
  std::array<int, kRows> rank_{};
  std::array<bool, kRows> out_{}, was_active_{}, active_{};

  std::array<State, kRows> before_;  ///< state before each row was last added to the active set
  Vec6 y0_ = Vec6::Zero();
  State now_;
  Eigen::Matrix<double, kVars, kVars> Q_, R_;  ///< factors of the matrix whose q columns are the active rows
};

}  // namespace palpate::guidance
