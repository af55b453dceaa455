#include "palpate/guidance/qp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::guidance {
namespace {

constexpr double kDependent = 1e-5;  // a unit row of which less is left beside the active ones is made of them
constexpr double kNever = std::numeric_limits<double>::infinity();

std::size_t at(int i) noexcept { return static_cast<std::size_t>(i); }

}  // namespace

int Qp::add(const Vec6& a, double b, int rank) noexcept {
  const double length = a.norm();
  if (m_ == kRows || !(length > 1e-12 && length < 1e12) || !std::isfinite(b)) return -1;
  a_[at(m_)] = a / length;
  b_[at(m_)] = b / length;
  length_[at(m_)] = length;
  rank_[at(m_)] = rank;
  return m_++;
}

void Qp::move(int from, int to) noexcept {
  a_[at(to)] = a_[at(from)];
  b_[at(to)] = b_[at(from)];
  length_[at(to)] = length_[at(from)];
  rank_[at(to)] = rank_[at(from)];
}

double Qp::slack(int i) const noexcept { return length(i) * (a_[at(i)].dot(now_.y) - b_[at(i)]); }

bool Qp::kept(const Vec6& y, int rows) const noexcept {
  for (int i = 0; i < rows; ++i) {
    if (a_[at(i)].dot(y) - b_[at(i)] < -kClose) return false;
  }
  return true;
}

// The row that lacks most, of the highest rank; of those first that were active the last time.
int Qp::most_violated() const noexcept {
  int worst = -1;
  double lack = 0.0;
  bool known = false;
  for (int i = 0; i < m_; ++i) {
    if (active_[at(i)] || out_[at(i)]) continue;
    const double s = a_[at(i)].dot(now_.y) - b_[at(i)];
    if (!(s < -kClose)) continue;
    const bool was = was_active_[at(i)];
    const int above = worst < 0 ? 1 : rank_[at(i)] - rank_[at(worst)];
    if (above > 0 || (above == 0 && ((was && !known) || (was == known && s < lack)))) worst = i, lack = s, known = was;
  }
  return worst;
}

// Q R of the active rows, by Gram and Schmidt, twice.
void Qp::factorise() noexcept {
  for (int k = 0; k < now_.q; ++k) {
    Vec6 z = a_[at(now_.set[at(k)])];
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
  active_[at(now_.set[at(k)])] = false;
  for (int j = k; j + 1 < now_.q; ++j) now_.set[at(j)] = now_.set[at(j + 1)], now_.u[at(j)] = now_.u[at(j + 1)];
  now_.u[at(now_.q - 1)] = now_.u[at(now_.q)];
  --now_.q;
  factorise();
}

// Row p = sum r_k a_k, all r_k <= 0, cannot be kept beside the active rows that it is made of: one of them gives way,
// and the search goes on from where that one was taken up.
void Qp::give_way(int p, const Vec6& r) noexcept {
  int least = p;
  for (int k = 0; k < now_.q; ++k) {
    const int i = now_.set[at(k)];
    if (r[k] < -kDependent && rank_[at(i)] < rank_[at(least)]) least = i;
  }
  out_[at(least)] = true;
  for (int k = 0; k < now_.q; ++k) active_[at(now_.set[at(k)])] = false;
  now_ = before_[at(least)];
  bool lost = false;
  for (int k = 0; k < now_.q; ++k) lost |= out_[at(now_.set[at(k)])];
  if (lost) now_ = {y0_, 0, {}, {}};
  for (int k = 0; k < now_.q; ++k) active_[at(now_.set[at(k)])] = true;
  factorise();
}

// Steps until row p is kept and active, or one has given way. False when the steps are used up.
bool Qp::take_up(int p) noexcept {
  before_[at(p)] = now_;
  now_.u[at(now_.q)] = 0.0;
  while (++steps_ <= kSteps) {
    const Vec6& a = a_[at(p)];
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
    double dual = kNever;  // as far as no multiplier turns negative
    int blocks = -1;
    for (int k = 0; k < now_.q; ++k) {
      if (r[k] > 0.0 && now_.u[at(k)] < dual * r[k]) dual = now_.u[at(k)] / r[k], blocks = k;
    }
    const double left = z.squaredNorm();
    const bool moves = now_.q < kVars && left > kDependent * kDependent;
    const double primal = moves ? (b_[at(p)] - a.dot(now_.y)) / left : kNever;
    if (!moves && blocks < 0) {  // p contradicts the active rows
      give_way(p, r);
      return true;
    }
    const double step = std::min(dual, primal);
    if (moves) now_.y += step * z;
    for (int k = 0; k < now_.q; ++k) now_.u[at(k)] -= step * r[k];
    now_.u[at(now_.q)] += step;
    if (dual < primal) {
      drop(blocks);
      continue;
    }
    now_.set[at(now_.q++)] = p;
    active_[at(p)] = true;
    factorise();
    return true;
  }
  return false;
}

// min |y - y0|^2 + sum w max(b - a . y, 0)^2 by Newton's method: piecewise quadratic, so that a few steps are exact.
void Qp::least_violation() noexcept {
  constexpr int kNewton = 12;
  constexpr double kWeight = 1e4, kHardly = 1e-6;  // from rank to rank; of the distance from y0
  int first = std::numeric_limits<int>::min(), second = first;
  for (int i = 0; i < m_; ++i) first = std::max(first, rank_[at(i)]);
  for (int i = 0; i < m_; ++i) {
    if (rank_[at(i)] < first) second = std::max(second, rank_[at(i)]);
  }
  Vec6& y = now_.y;
  for (int step = 0; step < kNewton; ++step) {
    Eigen::Matrix<double, kVars, kVars> H = kHardly * Eigen::Matrix<double, kVars, kVars>::Identity();
    Vec6 g = kHardly * (y0_ - y);
    for (int i = 0; i < m_; ++i) {
      const Vec6& a = a_[at(i)];
      const double lacks = b_[at(i)] - a.dot(y);
      if (lacks <= 0.0) continue;
      const double w = rank_[at(i)] == first ? kWeight * kWeight : rank_[at(i)] == second ? kWeight : 1.0;
      H.noalias() += w * a * a.transpose();
      g += w * lacks * a;
    }
    const Vec6 change = H.ldlt().solve(g);
    if (!change.allFinite()) return;
    y += change;
    if (change.norm() < kClose) return;
  }
}

Qp::Status Qp::solve(const Vec6& y0) noexcept {
  for (int i = 0; i < m_; ++i) active_[at(i)] = out_[at(i)] = false, lambda_[at(i)] = 0.0;
  y0_ = y0;
  now_ = {y0, 0, {}, {}};
  steps_ = 0;
  bool done = true;
  for (int p = most_violated(); p >= 0 && done; p = most_violated()) done = take_up(p);
  if (!done) least_violation();
  std::fill(was_active_.begin(), was_active_.end(), false);
  bool relaxed = false;
  for (int k = 0; k < now_.q; ++k) {
    const int i = now_.set[at(k)];
    lambda_[at(i)] = std::max(now_.u[at(k)], 0.0) / length(i);
    was_active_[at(i)] = true;
  }
  for (int i = 0; i < m_; ++i) relaxed |= out_[at(i)];
  return !done ? Status::stopped : relaxed ? Status::relaxed : Status::solved;
}

}  // namespace palpate::guidance
