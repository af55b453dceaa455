#include "palpate/guidance/qp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/types/index.hpp"
#include "palpate/types/ldlt.hpp"

namespace palpate::guidance {
namespace {

constexpr double kDependent = 1e-5;  // a unit row whose residual after projection is smaller depends on the active rows
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

int Qp::add(const Vec6& a, double b, int rank) noexcept {
  const double length = a.norm();
  if (m_ == kRows || !(length > 1e-12 && length < 1e12) || !std::isfinite(b)) return -1;
  a_[to_index(m_)] = a / length;
  b_[to_index(m_)] = b / length;
  length_[to_index(m_)] = length;
  rank_[to_index(m_)] = rank;
  return m_++;
}

void Qp::move(int from, int to) noexcept {
  a_[to_index(to)] = a_[to_index(from)];
  b_[to_index(to)] = b_[to_index(from)];
  length_[to_index(to)] = length_[to_index(from)];
  rank_[to_index(to)] = rank_[to_index(from)];
}

double Qp::slack(int i) const noexcept { return length(i) * (a_[to_index(i)].dot(now_.y) - b_[to_index(i)]); }

bool Qp::satisfies(const Vec6& y, int rows) const noexcept {
  for (int i = 0; i < rows; ++i) {
    if (a_[to_index(i)].dot(y) - b_[to_index(i)] < -kTolerance) return false;
  }
  return true;
}

// The most violated row of the highest rank; rows that were active in the last solution come first within their rank.
int Qp::most_violated() const noexcept {
  int worst = -1;
  double lack = 0.0;
  bool known = false;
  for (int i = 0; i < m_; ++i) {
    if (active_[to_index(i)] || out_[to_index(i)]) continue;
    const double s = a_[to_index(i)].dot(now_.y) - b_[to_index(i)];
    if (!(s < -kTolerance)) continue;
    const bool was = was_active_[to_index(i)];
    const int above = worst < 0 ? 1 : rank_[to_index(i)] - rank_[to_index(worst)];
    if (above > 0 || (above == 0 && ((was && !known) || (was == known && s < lack)))) worst = i, lack = s, known = was;
  }
  return worst;
}

// Q R factorisation of the active rows by Gram-Schmidt, repeated once for accuracy.
void Qp::factorise() noexcept {
  for (int k = 0; k < now_.q; ++k) {
    Vec6 z = a_[to_index(now_.set[to_index(k)])];
    R_.col(k).setZero();
    for (int twice = 0; twice < 2; ++twice) {
      for (int j = 0; j < k; ++j) {
        const double share = Q_.col(j).dot(z);
        R_(j, k) += share;
        z -= share * Q_.col(j);
      }
    }
    R_(k, k) = z.norm();
    Q_.col(k) = z / R_(k, k);
  }
}

void Qp::drop(int k) noexcept {
  active_[to_index(now_.set[to_index(k)])] = false;
  for (int j = k; j + 1 < now_.q; ++j)
    now_.set[to_index(j)] = now_.set[to_index(j + 1)], now_.u[to_index(j)] = now_.u[to_index(j + 1)];
  now_.u[to_index(now_.q - 1)] = now_.u[to_index(now_.q)];
  --now_.q;
  factorise();
}

// Row p = sum r_k a_k with all r_k <= 0 contradicts the active rows of which it is a combination. The row of the lowest
// rank among them is dropped, and the search resumes from the state before that row was added.
void Qp::drop_contradicting(int p, const Vec6& r) noexcept {
  int least = p;
  for (int k = 0; k < now_.q; ++k) {
    const int i = now_.set[to_index(k)];
    if (r[k] < -kDependent && rank_[to_index(i)] < rank_[to_index(least)]) least = i;
  }
  out_[to_index(least)] = true;
  for (int k = 0; k < now_.q; ++k) active_[to_index(now_.set[to_index(k)])] = false;
  now_ = before_[to_index(least)];
  bool lost = false;
  for (int k = 0; k < now_.q; ++k) lost |= out_[to_index(now_.set[to_index(k)])];
  if (lost) now_ = {y0_, 0, {}, {}};
  for (int k = 0; k < now_.q; ++k) active_[to_index(now_.set[to_index(k)])] = true;
  factorise();
}

// Steps until row p is satisfied and active, or a contradicting row has been dropped. Returns false when the steps are
// used up.
bool Qp::add_active(int p) noexcept {
  before_[to_index(p)] = now_;
  now_.u[to_index(now_.q)] = 0.0;
  while (++steps_ <= kSteps) {
    const Vec6& a = a_[to_index(p)];
    Vec6 z = a, d = Vec6::Zero();
    for (int twice = 0; twice < 2; ++twice) {
      for (int j = 0; j < now_.q; ++j) {
        const double share = Q_.col(j).dot(z);
        d[j] += share;
        z -= share * Q_.col(j);
      }
    }
    Vec6 r = d;
    for (int j = now_.q - 1; j >= 0; --j) {
      for (int k = j + 1; k < now_.q; ++k) r[j] -= R_(j, k) * r[k];
      r[j] /= R_(j, j);
    }
    double dual = kInfinity;  // largest step for which no multiplier turns negative
    int blocks = -1;
    for (int k = 0; k < now_.q; ++k) {
      if (r[k] > 0.0 && now_.u[to_index(k)] < dual * r[k]) dual = now_.u[to_index(k)] / r[k], blocks = k;
    }
    const double left = z.squaredNorm();
    const bool moves = now_.q < kVars && left > kDependent * kDependent;
    const double primal = moves ? (b_[to_index(p)] - a.dot(now_.y)) / left : kInfinity;
    if (!moves && blocks < 0) {  // p contradicts the active rows
      drop_contradicting(p, r);
      return true;
    }
    const double step = std::min(dual, primal);
    if (moves) now_.y += step * z;
    for (int k = 0; k < now_.q; ++k) now_.u[to_index(k)] -= step * r[k];
    now_.u[to_index(now_.q)] += step;
    if (dual < primal) {
      drop(blocks);
      continue;
    }
    now_.set[to_index(now_.q++)] = p;
    active_[to_index(p)] = true;
    factorise();
    return true;
  }
  return false;
}

// Minimises kRegularisation |y - y0|^2 + sum w max(b - a . y, 0)^2 by Newton's method. The function is piecewise
// quadratic, so a few steps reach the minimum.
void Qp::least_violation() noexcept {
  constexpr int kNewton = 12;
  constexpr double kWeight = 1e4, kRegularisation = 1e-6;  // ratio of weights between ranks; weight of |y - y0|^2
  int first = std::numeric_limits<int>::min(), second = first;
  for (int i = 0; i < m_; ++i) first = std::max(first, rank_[to_index(i)]);
  for (int i = 0; i < m_; ++i) {
    if (rank_[to_index(i)] < first) second = std::max(second, rank_[to_index(i)]);
  }
  Vec6& y = now_.y;
  for (int step = 0; step < kNewton; ++step) {
    Eigen::Matrix<double, kVars, kVars> H = kRegularisation * Eigen::Matrix<double, kVars, kVars>::Identity();
    Vec6 g = kRegularisation * (y0_ - y);
    for (int i = 0; i < m_; ++i) {
      const Vec6& a = a_[to_index(i)];
      const double lacks = b_[to_index(i)] - a.dot(y);
      if (lacks <= 0.0) continue;
      const double w = rank_[to_index(i)] == first ? kWeight * kWeight : rank_[to_index(i)] == second ? kWeight : 1.0;
      H.noalias() += w * a * a.transpose();
      g += w * lacks * a;
    }
    const Vec6 change = solve_ldlt(H, g);
    if (!change.allFinite()) return;
    y += change;
    if (change.norm() < kTolerance) return;
  }
}

Qp::Status Qp::solve(const Vec6& y0) noexcept {
  for (int i = 0; i < m_; ++i) active_[to_index(i)] = out_[to_index(i)] = false, lambda_[to_index(i)] = 0.0;
  y0_ = y0;
  now_ = {y0, 0, {}, {}};
  steps_ = 0;
  bool done = true;
  for (int p = most_violated(); p >= 0 && done; p = most_violated()) done = add_active(p);
  if (!done) least_violation();
  std::fill(was_active_.begin(), was_active_.end(), false);
  bool relaxed = false;
  for (int k = 0; k < now_.q; ++k) {
    const int i = now_.set[to_index(k)];
    lambda_[to_index(i)] = std::max(now_.u[to_index(k)], 0.0) / length(i);
    was_active_[to_index(i)] = true;
  }
  for (int i = 0; i < m_; ++i) relaxed |= out_[to_index(i)];
  return !done ? Status::stopped : relaxed ? Status::relaxed : Status::solved;
}

}  // namespace palpate::guidance
