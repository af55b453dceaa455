// The quadratic program of guidance: the nearest point that satisfies many half-spaces.
//
//   min |y - y0|^2 / 2    subject to    a_i . y >= b_i,   i = 1..m
//
// By the dual active-set method of Goldfarb and Idnani (1983), for the unit Hessian that this is: from the outside, one
// violated row after the other, each step exact, so that the answer is one after a few rows. No allocation, no lock;
// the number of steps is bounded; rows that contradict each other in more ways than that are violated as little as can
// be, those of a higher rank ten thousand times less (least_violation). What was tried for it, and why it is our own:
// docs/guidance-hard.md.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

class Qp {
 public:
  static constexpr int kVars = 6;
  static constexpr int kRows = 544;
  static constexpr int kSteps = 120;      ///< most rows taken up or dropped
  static constexpr double kClose = 1e-9;  ///< a row counts as kept when it lacks less [units of y]

  enum class Status {
    solved,   ///< every row is kept
    relaxed,  ///< rows contradict each other: those of the lowest rank gave way, the others are kept
    stopped,  ///< the steps were used up: y has the least sum of squared violations, weighed by rank
  };

  void clear() noexcept { m_ = 0; }
  /// Forgets the rows from m on.
  void truncate(int m) noexcept { m_ = m; }
  /// a . y >= b; among rows that contradict each other the one with the lowest rank gives way; of equal ones the one
  /// that is violated last, when those that lack most are taken up first.
  /// Returns its index; -1 when it is no row (not finite, or a = 0), or there is no room for it.
  int add(const Vec6& a, double b, int rank = 0) noexcept;
  /// Row `to` is what row `from` is.
  void move(int from, int to) noexcept;
  [[nodiscard]] int rows() const noexcept { return m_; }

  /// y0 finite. Rows that were active in the last solution are taken up first (warm start).
  Status solve(const Vec6& y0) noexcept;
  [[nodiscard]] const Vec6& y() const noexcept { return now_.y; }
  /// How much row i pushes: y - y0 = sum of multiplier_i a_i; never below zero.
  [[nodiscard]] double multiplier(int i) const noexcept { return lambda_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] bool gave_way(int i) const noexcept { return out_[static_cast<std::size_t>(i)]; }
  /// a_i as it was added.
  [[nodiscard]] Vec6 row(int i) const noexcept { return length(i) * a_[static_cast<std::size_t>(i)]; }
  /// a_i . y - b_i.
  [[nodiscard]] double slack(int i) const noexcept;
  /// The first `rows` rows are kept at y, but for kClose.
  [[nodiscard]] bool kept(const Vec6& y, int rows) const noexcept;
  [[nodiscard]] int steps() const noexcept { return steps_; }

 private:
  /// The nearest point that keeps the active rows.
  struct State {
    Vec6 y = Vec6::Zero();
    int q = 0;                          ///< active rows
    std::array<int, kVars> set{};       ///< which
    std::array<double, kVars + 1> u{};  ///< their multipliers, of the unit rows; then that of the row being taken up
  };

  [[nodiscard]] int most_violated() const noexcept;
  bool take_up(int p) noexcept;
  void factorise() noexcept;
  void drop(int k) noexcept;
  void give_way(int p, const Vec6& r) noexcept;
  void least_violation() noexcept;
  [[nodiscard]] double length(int i) const noexcept { return length_[static_cast<std::size_t>(i)]; }

  int m_ = 0, steps_ = 0;
  std::array<Vec6, kRows> a_;  ///< unit
  std::array<double, kRows> b_{}, length_{}, lambda_{};
  std::array<int, kRows> rank_{};
  std::array<bool, kRows> out_{}, was_active_{}, active_{};

  std::array<State, kRows> before_;  ///< of each row, when it was taken up last
  Vec6 y0_ = Vec6::Zero();
  State now_;
  Eigen::Matrix<double, kVars, kVars> Q_, R_;  ///< [a_set] = Q R, the first q columns
};

}  // namespace palpate::guidance
