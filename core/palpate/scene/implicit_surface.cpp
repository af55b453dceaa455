#include "palpate/scene/implicit_surface.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace palpate::scene {
namespace {

constexpr int kBisections = 100;     // after so many bisections a bracket has no digits left
constexpr double kRounding = 1e-15;  // relative change at which an iteration ends

/// x^n for n >= 0.
double power(double x, int n) {
  double out = 1.0;
  for (; n > 0; n /= 2, x *= x)
    if (n % 2 == 1) out *= x;
  return out;
}

}  // namespace

ImplicitSurface::ImplicitSurface(const Vec3& coefficients, const std::array<int, 3>& exponents, double level)
    : coefficient_(coefficients), half_(Vec3::Zero()), exponent_(exponents), level_(level) {
  if (!(level > 0.0) || !std::isfinite(level))
    throw std::invalid_argument("level of an implicit surface must be positive, got " + std::to_string(level));
  for (int i = 0; i < 3; ++i) {
    const int n = exponents[static_cast<std::size_t>(i)];
    if (!(coefficients[i] > 0.0) || !std::isfinite(coefficients[i]))
      throw std::invalid_argument("coefficients of an implicit surface must be positive, got " +
                                  std::to_string(coefficients[i]));
    if (n < 2 || n > 12 || n % 2 != 0)
      throw std::invalid_argument("exponents of an implicit surface must be 2, 4, ... 12, got " + std::to_string(n));
    half_[i] = std::pow(level / coefficients[i], 1.0 / n);
  }
  if (!half_.allFinite() || half_.minCoeff() <= 0.0)
    throw std::invalid_argument("coefficients and level of an implicit surface give it no finite size");
}

double ImplicitSurface::value(const Vec3& p) const noexcept {
  double u = -level_;
  for (int i = 0; i < 3; ++i) u += coefficient_[i] * power(p[i], exponent_[static_cast<std::size_t>(i)]);
  return u;
}

Vec3 ImplicitSurface::gradient(const Vec3& p) const noexcept {
  Vec3 g;
  for (int i = 0; i < 3; ++i) {
    const int n = exponent_[static_cast<std::size_t>(i)];
    g[i] = coefficient_[i] * n * power(p[i], n - 1);
  }
  return g;
}

Nearest ImplicitSurface::nearest(const Vec3& p) const noexcept {
  const Vec3 q = p.cwiseAbs();  // the surface is symmetric: its nearest point is in the same octant as p
  const bool outside = value(q) > 0.0;
  const Vec3 x = (outside ? from_outside(q) : from_inside(q)).cwiseMax(0.0);
  Nearest found;
  for (int i = 0; i < 3; ++i) found.point[i] = std::copysign(x[i], p[i]);
  found.normal = gradient(found.point).normalized();
  found.distance = (outside ? 1.0 : -1.0) * (p - found.point).norm();
  return found;
}

/// Solves x + multiplier a m x^(m-1) = p for the coordinate x >= 0 along one axis, by Newton's method from the right
/// side of a convex function.
double ImplicitSurface::solve_axis(int axis, double p, double multiplier) const noexcept {
  const int n = exponent_[static_cast<std::size_t>(axis)];
  const double k = multiplier * coefficient_[axis] * n;
  double x = p;
  for (int step = 0; step < kBisections; ++step) {
    const double slope = k * power(x, n - 2);
    const double move = (x + slope * x - p) / (1.0 + (n - 1) * slope);
    x -= move;
    if (std::abs(move) <= kRounding * p) break;
  }
  return x;
}

/// Solves x + lambda grad U(x) = p and U(x) = level with lambda > 0. The inner loop solves each axis for a given
/// lambda; the outer loop finds lambda.
Vec3 ImplicitSurface::from_outside(const Vec3& p) const noexcept {
  double low = 0.0, high = std::numeric_limits<double>::infinity(), multiplier = 0.0;
  Vec3 x = p;
  for (int step = 0; step < kBisections; ++step) {
    for (int i = 0; i < 3; ++i) x[i] = solve_axis(i, p[i], multiplier);
    const double u = value(x);
    (u > 0.0 ? low : high) = multiplier;
    double slope = 0.0;  // dU/dlambda
    const Vec3 g = gradient(x);
    for (int i = 0; i < 3; ++i) {
      const int n = exponent_[static_cast<std::size_t>(i)];
      slope -= g[i] * g[i] / (1.0 + multiplier * coefficient_[i] * n * (n - 1) * power(x[i], n - 2));
    }
    double next = multiplier - u / slope;
    if (!(next > low) || !(next < high)) next = std::isfinite(high) ? 0.5 * (low + high) : 2.0 * low;
    if (std::abs(next - multiplier) <= kRounding * next) break;
    multiplier = next;
  }
  return x;
}

/// Nearest point for p inside. There may be several local solutions, so the search starts at the surface points in
/// seven directions of the octant and keeps the best result.
Vec3 ImplicitSurface::from_inside(const Vec3& p) const noexcept {
  Vec3 best = intersect_ray(p, half_);
  double least = (best - p).squaredNorm();
  for (unsigned mask = 1; mask < 8; ++mask) {
    const Vec3 direction((mask & 1U) != 0 ? half_.x() : 0.0, (mask & 2U) != 0 ? half_.y() : 0.0,
                         (mask & 4U) != 0 ? half_.z() : 0.0);
    Vec3 x = intersect_ray(p, direction);
    if (!project_iteratively(p, x)) continue;
    const double distance = (x - p).squaredNorm();
    if (distance < least) {
      least = distance;
      best = x;
    }
  }
  return best;
}

/// Intersection of the ray from p inside with the surface, by Newton's method from the far side of a convex function.
Vec3 ImplicitSurface::intersect_ray(const Vec3& p, const Vec3& direction) const noexcept {
  double t = 2.0 * half_.norm() / direction.norm();  // a point outside, whatever the direction
  for (int step = 0; step < kBisections; ++step) {
    const Vec3 x = p + t * direction;
    const double move = value(x) / gradient(x).dot(direction);
    t -= move;
    if (!(move > kRounding * t)) break;
  }
  return p + t * direction;
}

/// Moves x on the surface to the foot point of p by repeated projection onto the tangent plane, until p - x is parallel
/// to grad U. Returns false if x does not converge.
bool ImplicitSurface::project_iteratively(const Vec3& p, Vec3& x) const noexcept {
  const double close = kRounding * half_.maxCoeff();
  for (int step = 0; step < 10; ++step) {
    const Vec3 n = gradient(x).normalized(), before = x;
    x = (p - n * n.dot(p - x)).cwiseMax(0.0);
    for (int landing = 0; landing < 4; ++landing) {
      const Vec3 g = gradient(x);
      x -= value(x) / g.squaredNorm() * g;
    }
    if (!x.allFinite()) return false;
    if ((x - before).norm() <= close) break;
  }
  refine(p, x);
  return std::abs(value(x)) <= 1e-12 * level_;
}

/// Refines x by Newton's method on x + lambda grad U = p and U = level, whose matrix is diagonal except for one row and
/// one column. The result is kept only if it is on the surface and not farther from p.
void ImplicitSurface::refine(const Vec3& p, Vec3& x) const noexcept {
  Vec3 y = x, g = gradient(y);
  double multiplier = g.dot(p - y) / g.squaredNorm();
  for (int step = 0; step < 12; ++step) {
    Vec3 stiffness;
    for (int i = 0; i < 3; ++i) {
      const int n = exponent_[static_cast<std::size_t>(i)];
      stiffness[i] = 1.0 + multiplier * coefficient_[i] * n * (n - 1) * power(y[i], n - 2);
    }
    const Vec3 residual = y - p + multiplier * g;
    const double change = (value(y) - g.dot(residual.cwiseQuotient(stiffness))) / g.dot(g.cwiseQuotient(stiffness));
    const Vec3 move = (residual + change * g).cwiseQuotient(stiffness);
    if (!move.allFinite() || !std::isfinite(change)) return;
    y -= move;
    multiplier += change;
    g = gradient(y);
    if (move.norm() <= kRounding * half_.maxCoeff()) break;
  }
  const bool on = std::abs(value(y)) <= 1e-12 * level_ && (y.array() >= 0.0).all();
  if (on && (y - p).norm() <= (x - p).norm() * (1.0 + 1e-9)) x = y;
}

}  // namespace palpate::scene
