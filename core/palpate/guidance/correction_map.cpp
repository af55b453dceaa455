#include "palpate/guidance/correction_map.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/index.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::guidance {
namespace {

constexpr double kPivot = 1e-10;    // a smaller pivot means that the rows depend on each other
constexpr double kMostGain = 30.0;  // largest motion of the corrected goal per motion of the mapped goal
constexpr int kUnknowns = 6 + CorrectionMap::kRows;

/// Solves A X = B by elimination with column pivots, in place of B. False if A is singular.
template <int Columns>
bool eliminate(Eigen::Matrix<double, kUnknowns, kUnknowns>& A, Eigen::Matrix<double, kUnknowns, Columns>& B,
               int n) noexcept {
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(A(i, k)) > std::abs(A(best, k))) best = i;
    }
    if (!(std::abs(A(best, k)) > kPivot)) return false;
    if (best != k) A.row(k).swap(A.row(best)), B.row(k).swap(B.row(best));
    for (int i = k + 1; i < n; ++i) {
      const double f = A(i, k) / A(k, k);
      if (f == 0.0) continue;
      for (int j = k; j < n; ++j) A(i, j) -= f * A(k, j);
      B.row(i) -= f * B.row(k);
    }
  }
  for (int k = n - 1; k >= 0; --k) {
    for (int j = k + 1; j < n; ++j) B.row(k) -= A(k, j) * B.row(j);
    B.row(k) /= A(k, k);
  }
  return true;
}

/// True if the symmetric part of P has no eigenvalue below -1e-6.
bool positive(const Mat6& P) noexcept {
  Mat6 S = 0.5 * (P + P.transpose()) + 1e-6 * Mat6::Identity();
  for (int k = 0; k < 6; ++k) {
    if (!(S(k, k) > 0.0)) return false;
    for (int i = k + 1; i < 6; ++i) {
      const double f = S(i, k) / S(k, k);
      for (int j = k + 1; j < 6; ++j) S(i, j) -= f * S(k, j);
    }
  }
  return true;
}

/// The second derivative P^T M P of the distance, for a goal that some rows may only turn: it is the nearest one among
/// all orientations at its position, and among all positions, but not among all poses.
Mat6 second_order_by_parts(const Mat6& P, const Mat6& M) noexcept {
  Mat6 S = Mat6::Zero();
  for (const int k : {0, 3}) {
    const Mat3 part = P.block<3, 3>(k, k);
    S.block<3, 3>(k, k) = part.transpose() * M.block<3, 3>(k, k) * part;
  }
  return S;
}

Wrench physical(const Vec6& row) noexcept { return {row.head<3>(), kLength * row.tail<3>()}; }

}  // namespace

void CorrectionMap::clear() noexcept {
  rows_ = 0;
  P_.setIdentity();
}

bool CorrectionMap::add(const ActiveRow& row) noexcept {
  if (rows_ == kRows) return false;
  row_[to_index(rows_++)] = row;
  return true;
}

void CorrectionMap::solve(const Vec6& y) noexcept {
  if (rows_ == 0) return;
  if (!try_solve(y, true) && !try_solve(y, false)) {
    P_.setZero();  // the rows determine the whole goal
    dl_.setZero();
  }
}

bool CorrectionMap::try_solve(const Vec6& y, bool curved) noexcept {
  Mat6 M = Mat6::Identity(), N = Mat6::Identity();
  if (curved) {
    M.bottomRightCorner<3, 3>() = rotation_vector_derivative(y.tail<3>() / kLength);
    N.bottomRightCorner<3, 3>() = M.bottomRightCorner<3, 3>().transpose();
  }
  const Mat6 E = M;
  const int n = 6 + rows_;
  Eigen::Matrix<double, kUnknowns, kUnknowns> A = Eigen::Matrix<double, kUnknowns, kUnknowns>::Zero();
  Eigen::Matrix<double, kUnknowns, 6> B = Eigen::Matrix<double, kUnknowns, 6>::Zero();
  bool turns_only = false;  // a row with a target that depends on the position, which it does not change
  for (int r = 0; r < rows_; ++r) {
    const ActiveRow& row = row_[to_index(r)];
    turns_only |= curved && row.a.head<3>().isZero(0.0) && !row.g.head<3>().isZero(0.0);
    if (curved) M -= row.lambda * row.H;
    A.block<6, 1>(0, 6 + r) = -row.a;
    A.block<1, 6>(6 + r, 0) = (curved ? row.g : row.a).transpose();
    B.row(6 + r) = row.b.transpose();
  }
  A.topLeftCorner<6, 6>() = M;
  B.topRows<6>() = N;
  if (!eliminate(A, B, n)) return false;
  const Mat6 P = B.topRows<6>();
  if (!P.allFinite() || !(P.norm() < kMostGain)) return false;
  if (!positive(turns_only ? second_order_by_parts(P, M) : Mat6(P.transpose() * M * P))) return false;
  P_ = P;
  dl_.setZero();
  dl_.topRows(rows_) = B.middleRows(6, rows_);
  curved_ = curved;
  size_ = y.norm();
  d_size_ = size_ > 0.0 ? Vec6((E * P - N).transpose() * y / size_) : Vec6(Vec6::Zero());
  parts_ = 0.0;
  d_parts_.setZero();
  for (int r = 0; r < rows_; ++r) {
    if (!begins_part(r)) continue;
    const Part part = part_of(r);
    parts_ += part.length * part.length;
    d_parts_ += part.length * part.d_length;
  }
  parts_ = std::sqrt(parts_);
  if (parts_ > 0.0) d_parts_ /= parts_;
  return true;
}

// True if no earlier row belongs to the same fixture. Every joint limit is a part of its own.
bool CorrectionMap::begins_part(int r) const noexcept {
  const int fixture = row_[to_index(r)].fixture;
  return fixture < 0 ||
         std::none_of(row_.begin(), row_.begin() + r, [&](const auto& o) { return o.fixture == fixture; });
}

// The part of the correction by the fixture of row r, or by the joint limit r.
CorrectionMap::Part CorrectionMap::part_of(int r) const noexcept {
  const int fixture = row_[to_index(r)].fixture;
  Vec6 v = Vec6::Zero();
  for (int i = r; i < rows_; ++i) {
    const ActiveRow& row = row_[to_index(i)];
    if (i == r || (fixture >= 0 && row.fixture == fixture)) v += row.lambda * row.a;
  }
  Part part;
  part.length = v.norm();
  if (!(part.length > 0.0)) return part;
  const Vec6 unit = v / part.length;
  double lambdas = 0.0, squares = 0.0;
  for (int i = r; i < rows_; ++i) {
    const ActiveRow& row = row_[to_index(i)];
    if (i != r && (fixture < 0 || row.fixture != fixture)) continue;
    lambdas += row.lambda;
    squares += row.lambda * row.a.squaredNorm();
    part.d_length += unit.dot(row.a) * dl_.row(i).transpose();
    if (!curved_) continue;
    part.d_length += row.lambda * P_.transpose() * (row.H.transpose() * unit);
    part.d_stretch += row.lambda * P_.transpose() * (row.H.transpose() * row.a);
  }
  part.stretch = std::sqrt(squares / lambdas);
  part.d_stretch /= lambdas * part.stretch;
  return part;
}

CorrectionMap::Share CorrectionMap::share(int fixture) const noexcept {
  for (int r = 0; r < rows_; ++r) {
    const ActiveRow& row = row_[to_index(r)];
    if (row.fixture != fixture) continue;
    if (row.turns) return {row.plain_lambda * row.plain.squaredNorm(), physical(row.plain)};
    const Part part = part_of(r);
    if (!(part.length > 0.0 && parts_ > 0.0)) return {};
    const double skew = size_ / parts_;
    const Vec6 d_skew = (d_size_ - skew * d_parts_) / parts_;
    const Vec6 d =
        skew * (part.stretch * part.d_length + part.length * part.d_stretch) + part.stretch * part.length * d_skew;
    // Below an authority of one the goal moves by that fraction only; the direction is that of the whole correction.
    return {skew * part.stretch * part.length, physical(-d / (1.0 - row.b.norm() / row.g.norm()))};
  }
  return {};
}

Mat6 CorrectionMap::jacobian() const noexcept {
  Mat6 J = P_;
  for (int r = 0; r < rows_; ++r) {
    if (row_[to_index(r)].by_force) J -= row_[to_index(r)].a * dl_.row(r);
  }
  J.topRightCorner<3, 3>() *= kLength;
  J.bottomLeftCorner<3, 3>() /= kLength;
  return J;
}

}  // namespace palpate::guidance
