#include "palpate/guidance/geometry/path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "palpate/types/so3.hpp"

namespace palpate::guidance {
namespace {

using Controls = Path::Controls;
using Quintic = std::array<double, 6>;  // Bernstein coefficients on an interval of u

constexpr int kHalvings = 12;  // bisections of a piece after which its roots count as isolated

Vec3 at(const Controls& c, double u) noexcept {
  const double w = 1.0 - u;
  return w * w * w * c[0] + 3.0 * w * w * u * c[1] + 3.0 * w * u * u * c[2] + u * u * u * c[3];
}

Vec3 slope(const Controls& c, double u) noexcept {
  const double w = 1.0 - u;
  return 3.0 * (w * w * (c[1] - c[0]) + 2.0 * w * u * (c[2] - c[1]) + u * u * (c[3] - c[2]));
}

/// Arc length from 0 to u by five-point Gauss-Legendre quadrature [m].
double arc(const Controls& c, double u) noexcept {
  constexpr double x[] = {0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr double w[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  double sum = w[0] * slope(c, 0.5 * u).norm();
  for (int i = 1; i < 3; ++i)
    sum += w[i] * (slope(c, 0.5 * u * (1.0 - x[i])).norm() + slope(c, 0.5 * u * (1.0 + x[i])).norm());
  return 0.5 * u * sum;
}

/// (c(u) - p) . c'(u): half the derivative of the squared distance from p to c(u).
Quintic slope_of_distance(const Controls& c, const Vec3& p) noexcept {
  constexpr double b3[] = {1, 3, 3, 1}, b2[] = {1, 2, 1}, b5[] = {1, 5, 10, 10, 5, 1};
  Quintic f{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 3; ++j) f[i + j] += b3[i] * b2[j] / b5[i + j] * 3.0 * (c[i] - p).dot(c[j + 1] - c[j]);
  return f;
}

/// Value and derivative of f at u.
std::pair<double, double> value(Quintic f, double u) noexcept {
  double derivative = 0.0;
  for (std::size_t n = 5; n > 0; --n) {
    if (n == 1) derivative = 5.0 * (f[1] - f[0]);
    for (std::size_t i = 0; i < n; ++i) f[i] += u * (f[i + 1] - f[i]);
  }
  return {f[0], derivative};
}

int sign_changes(const Quintic& f) noexcept {
  int changes = 0;
  double last = 0.0;
  for (const double v : f) {
    if (v == 0.0) continue;
    changes += last * v < 0.0 ? 1 : 0;
    last = v;
  }
  return changes;
}

/// The coefficients of f on both halves of its interval, by de Casteljau's algorithm.
std::pair<Quintic, Quintic> halves(Quintic f) noexcept {
  Quintic left;
  for (std::size_t n = 5;; --n) {
    left[5 - n] = f[0];
    if (n == 0) return {left, f};
    for (std::size_t i = 0; i < n; ++i) f[i] = 0.5 * (f[i] + f[i + 1]);
  }
}

/// The root in (0, 1) of an f that changes its sign once, from negative to positive.
double root(const Quintic& f) noexcept {
  double a = 0.0, b = 1.0, u = f[0] / (f[0] - f[5]);
  for (int step = 0; step < 60; ++step) {
    const auto [v, derivative] = value(f, u);
    (v < 0.0 ? a : b) = u;
    double next = u - v / derivative;
    if (!(next > a && next < b)) next = 0.5 * (a + b);
    if (std::abs(next - u) <= 1e-14) return next;
    u = next;
  }
  return u;
}

void check(bool good, const std::string& otherwise) {
  if (!good) throw std::invalid_argument(otherwise);
}

}  // namespace

Path::Path(std::vector<Controls> pieces, std::span<const Mat3> attitudes, bool tangential, bool closed)
    : pieces_(std::move(pieces)), tangential_(tangential), closed_(closed) {
  check(!pieces_.empty(), "a path needs at least one piece");
  check(attitudes.size() == pieces_.size() + 1, "a path of " + std::to_string(pieces_.size()) +
                                                    " pieces needs one attitude more, got " +
                                                    std::to_string(attitudes.size()));
  start_.push_back(0.0);
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const std::string name = "piece " + std::to_string(i) + " of the path ";
    for (const Vec3& c : pieces_[i])
      check(c.allFinite() && c.cwiseAbs().maxCoeff() <= kMaxCoordinate, name + "is not finite, or beyond 1000 km");
    const Vec3& end = i > 0 ? pieces_[i - 1][3] : closed ? pieces_.back()[3] : pieces_[i][0];
    check((pieces_[i][0] - end).norm() < 1e-9, name + "does not begin where the one before ends");
    check(slope(pieces_[i], 0.0).norm() > 0.0 && slope(pieces_[i], 1.0).norm() > 0.0, name + "stands still");
    start_.push_back(start_.back() + arc(pieces_[i], 1.0));
  }
  for (const Mat3& R : attitudes) {
    Eigen::Quaterniond q(R);
    check(std::abs(q.norm() - 1.0) < 1e-6, "attitudes of a path must be rotations");
    attitude_.push_back(q.normalized());
  }
  build_tree();
}

void Path::build_tree() {
  while (leaves_ < pieces_.size()) leaves_ *= 2;
  const Vec3 far = Vec3::Constant(std::numeric_limits<double>::max());
  box_.assign(2 * leaves_ - 1, {far, -far});  // empty
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    Box& box = box_[leaves_ - 1 + i];
    for (const Vec3& c : pieces_[i]) box = {box.lowest.cwiseMin(c), box.highest.cwiseMax(c)};
  }
  for (std::size_t i = leaves_ - 1; i-- > 0;) {
    const Box &left = box_[2 * i + 1], &right = box_[2 * i + 2];
    box_[i] = {left.lowest.cwiseMin(right.lowest), left.highest.cwiseMax(right.highest)};
  }
}

/// Updates `best` with the ends of one piece and with all local minima of its distance to p.
void Path::update_nearest(std::size_t piece, const Vec3& p, Best& best) const noexcept {
  const Controls& c = pieces_[piece];
  const auto consider = [&](double u) {
    const double distance2 = (at(c, u) - p).squaredNorm();
    if (distance2 < best.distance2) best = {distance2, u, piece};
  };
  consider(0.0);
  consider(1.0);
  struct Interval {
    Quintic f;
    double u, width;
  };
  std::array<Interval, kHalvings + 2> stack;
  std::size_t top = 0;
  stack[top++] = {slope_of_distance(c, p), 0.0, 1.0};
  while (top > 0) {
    const Interval here = stack[--top];
    const int changes = sign_changes(here.f);
    const double half = 0.5 * here.width;
    if (changes <= 1 || half < std::ldexp(1.0, -kHalvings)) {
      if (here.f[0] < 0.0 && here.f[5] > 0.0) consider(here.u + here.width * root(here.f));
      continue;
    }
    const auto [left, right] = halves(here.f);
    consider(here.u + half);
    stack[top++] = {left, here.u, half};
    stack[top++] = {right, here.u + half, half};
  }
}

/// Visits the boxes nearest first and skips those that are farther than the best point so far.
Path::Best Path::nearest(const Vec3& p) const noexcept {
  Best best{std::numeric_limits<double>::infinity(), 0.0, 0};
  struct Entry {
    double distance2;
    std::size_t node;
  };
  std::array<Entry, 70> stack;  // one entry per level of the tree, and one: no memory holds more pieces
  std::size_t top = 0;
  stack[top++] = {box_[0].distance2(p), 0};
  while (top > 0) {
    const auto [distance2, node] = stack[--top];
    if (distance2 >= best.distance2) continue;
    if (node >= leaves_ - 1) {
      update_nearest(node - (leaves_ - 1), p, best);
      continue;
    }
    Entry near{box_[2 * node + 1].distance2(p), 2 * node + 1}, far{box_[2 * node + 2].distance2(p), 2 * node + 2};
    if (far.distance2 < near.distance2) std::swap(near, far);
    if (far.distance2 < best.distance2) stack[top++] = far;
    stack[top++] = near;
  }
  return best;
}

Mat3 Path::attitude(const Best& where, double arc_length, const Vec3& tangent) const noexcept {
  const double whole = start_[where.piece + 1] - start_[where.piece];
  const double share = std::clamp((arc_length - start_[where.piece]) / whole, 0.0, 1.0);
  const Mat3 R = attitude_[where.piece].slerp(share, attitude_[where.piece + 1]).toRotationMatrix();
  if (!tangential_) return R;
  return rotation_between(R.col(2), tangent) * R;
}

Query Path::query_local(const Pose& X_WT, double, double) const noexcept {
  const Best best = nearest(X_WT.p);
  const Controls& c = pieces_[best.piece];
  const Vec3 tangent = slope(c, best.u).normalized(), point = at(c, best.u);
  const double over = tangent.dot(X_WT.p - point);
  const bool before = best.piece == 0 && best.u <= 0.0 && over < 0.0;
  const bool after = best.piece + 1 == pieces_.size() && best.u >= 1.0 && over > 0.0;
  Query q = point_or_curve_query(X_WT.p, point, !closed_ && (before || after) ? nullptr : &tangent);
  q.arc_length = start_[best.piece] + arc(c, best.u);
  q.attitude = attitude(best, q.arc_length, tangent);
  return q;
}

}  // namespace palpate::guidance
