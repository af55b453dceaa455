#include "palpate/scene/smooth.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/scene/topology.hpp"
#include "palpate/types/index.hpp"

namespace palpate::scene {
namespace {

constexpr int kMaxWalk = 48;        // facets visited by one walk
constexpr int kMaxNewton = 12;      // Newton steps on one facet
constexpr double kSettled = 1e-13;  // convergence tolerance of the barycentric weights
constexpr double kRim = 1e-9;       // a weight above -kRim is inside the facet (rounding)

/// Height h of the smooth surface over a facet, as a function of the barycentric weights b.
class Height {
 public:
  Height(const Vec3 edge[3], const Vec3 n[3]) {
    for (int k = 0; k < 3; ++k) {
      bend_[k] = 0.5 * edge[k].dot(n[(k + 2) % 3] - n[(k + 1) % 3]);
      lean_[k] = 0.5 * edge[k].dot(n[(k + 2) % 3] + n[(k + 1) % 3]);
    }
    for (int k = 0; k < 3; ++k) bump_[k] = across_edge(k, edge, n);
  }

  /// Height and its derivatives with respect to v and w [m].
  struct Value {
    double h, dv, dw;
  };

  [[nodiscard]] Value at(const SurfacePoint& s) const {
    const double b[3] = {s.u(), s.v, s.w};
    double h = 0.0, d[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; ++k) {
      const int i = (k + 1) % 3, j = (k + 2) % 3;
      h += b[i] * b[j] * (bend_[k] - lean_[k] * (b[i] - b[j]));
      d[i] += b[j] * (bend_[k] - lean_[k] * (2.0 * b[i] - b[j]));
      d[j] += b[i] * (bend_[k] - lean_[k] * (b[i] - 2.0 * b[j]));
      const double ki = b[k] + b[i], kj = b[k] + b[j];
      if (!(std::min(ki, kj) > kRim)) continue;  // at a corner the bump and its slopes vanish
      const double r = bump_[k] * b[i] * b[j] / (ki * kj);
      h += r * b[i] * b[j] * b[k];
      d[k] += r * b[i] * b[j] * (1.0 - b[k] / ki - b[k] / kj);
      d[i] += r * b[j] * b[k] * (2.0 - b[i] / ki);
      d[j] += r * b[i] * b[k] * (2.0 - b[j] / kj);
    }
    return {h, d[1] - d[0], d[2] - d[0]};
  }

 private:
  /// Bump coefficient of edge k. It gives the surface zero slope at the middle of the edge, perpendicular to the edge
  /// and to the mean normal, so that the slopes on both sides of the edge agree.
  [[nodiscard]] double across_edge(int k, const Vec3 edge[3], const Vec3 n[3]) const {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const Vec3 middle = (n[i] + n[j]).normalized(), across = 0.5 * (edge[i] - edge[j]);
    const Vec3 flat = edge[k] - middle.dot(edge[k]) * middle;
    const double along = middle.dot(edge[k]) + 0.5 * lean_[k];
    const double slope = middle.dot(across) + 0.5 * (bend_[i] + bend_[j] - bend_[k]) + 0.25 * (lean_[j] - lean_[i]);
    const double target_slope = along * across.dot(flat) / flat.squaredNorm();
    return std::isfinite(target_slope) ? 4.0 * (target_slope - slope) : 0.0;
  }

  double bend_[3], lean_[3], bump_[3];  // edge k is opposite to corner k
};

/// One facet with its interpolated normal N(v, w) = n0 + v m1 + w m2.
struct Facet {
  Vec3 a, e1, e2;   // corner 0 and the edges to corners 1 and 2 [m]
  Vec3 n0, m1, m2;  // normal at corner 0 and its change along the edges

  Facet(const Mesh::Impl& mesh, std::int32_t triangle) {
    const std::int32_t c = 3 * triangle;
    a = mesh.corner(c);
    e1 = mesh.corner(c + 1) - a;
    e2 = mesh.corner(c + 2) - a;
    n0 = mesh.normal(c);
    m1 = mesh.normal(c + 1) - n0;
    m2 = mesh.normal(c + 2) - n0;
  }

  [[nodiscard]] Height::Value height(const SurfacePoint& s) const {
    const Vec3 edges[3] = {e2 - e1, -e2, e1}, normals[3] = {n0, n0 + m1, n0 + m2};
    return Height(edges, normals).at(s);
  }

  /// Point of the smooth surface over s, with distance and gradient for the query point p.
  [[nodiscard]] SmoothPoint evaluate(const SurfacePoint& s, const Vec3& p) const {
    SmoothPoint out;
    const Vec3 N = n0 + s.v * m1 + s.w * m2;
    const double length = N.norm();
    if (!(length > 0.0)) return out;
    const Vec3 n = N / length, foot = a + s.v * e1 + s.w * e2;
    const Height::Value height = this->height(s);
    const double t = n.dot(p - foot) / length;
    const Vec3 jv = e1 + t * m1, jw = e2 + t * m2;
    const double det = jv.cross(jw).dot(N);
    // The gradient of distance = t |N| - h(v, w) follows from p = foot(v, w) + t N(v, w) by implicit differentiation.
    const double dv = t * n.dot(m1) - height.dv, dw = t * n.dot(m2) - height.dw;
    out.at = s;
    out.point = foot + height.h * n;
    out.above = t >= 0.0;
    out.distance = t * length - height.h;
    out.gradient = (dv * jw.cross(N) + dw * N.cross(jv) + length * jv.cross(jw)) / det;
    out.focal_factor = det / e1.cross(e2).dot(N);
    out.found = out.gradient.allFinite();
    return out;
  }

  /// Solves a + v e1 + w e2 + t N(v, w) = p by Newton's method. Returns false near a focal point, where the equation
  /// has no unique solution.
  bool solve(SurfacePoint& s, const Vec3& p) const {
    const Vec3 flat = e1.cross(e2);
    Vec3 N = n0 + s.v * m1 + s.w * m2;
    double t = N.dot(p - a - s.v * e1 - s.w * e2) / N.squaredNorm();
    for (int i = 0; i < kMaxNewton; ++i) {
      N = n0 + s.v * m1 + s.w * m2;
      const Vec3 residual = p - a - s.v * e1 - s.w * e2 - t * N;
      const Vec3 jv = e1 + t * m1, jw = e2 + t * m2;
      const Vec3 jvw = jv.cross(jw);
      const double det = jvw.dot(N);
      if (!(det > 1e-3 * flat.dot(N))) return false;  // the normals of this facet meet before they reach p
      const double dv = residual.dot(jw.cross(N)) / det, dw = residual.dot(N.cross(jv)) / det;
      s.v += dv;
      s.w += dw;
      t += residual.dot(jvw) / det;
      if (std::max(std::abs(dv), std::abs(dw)) < kSettled) return true;
      // Far outside the facet, the solution only gives the direction of the walk.
      if (std::max(std::abs(s.v), std::abs(s.w)) > 4.0) return true;
      if (i > 1 && std::max(std::abs(dv), std::abs(dw)) < 1e-9) return true;
    }
    return true;
  }
};

/// Corner with the most negative weight; the walk crosses the opposite edge. -1: the point is inside the facet.
int exit_corner(const SurfacePoint& s) {
  const double b[3] = {s.u(), s.v, s.w};
  const auto least = static_cast<int>(std::min_element(b, b + 3) - b);
  return b[least] < -kRim ? least : -1;
}

/// Surface point with barycentric weights proportional to b.
SurfacePoint from_weights(std::int32_t triangle, const double b[3]) {
  const double sum = b[0] + b[1] + b[2];
  return {triangle, b[1] / sum, b[2] / sum};
}

/// Moves the point onto the edge opposite to `corner`.
SurfacePoint onto_edge(const SurfacePoint& s, int corner) {
  double b[3] = {std::max(s.u(), 0.0), std::max(s.v, 0.0), std::max(s.w, 0.0)};
  b[corner] = 0.0;
  return from_weights(s.triangle, b);
}

/// The same edge point on the adjacent triangle. Its triangle is -1 if the edge is a crease or a boundary.
SurfacePoint across(const Mesh::Impl& mesh, const SurfacePoint& s, int corner) {
  const std::int32_t he = 3 * s.triangle + (corner + 1) % 3;  // the edge opposite to `corner`
  const std::int32_t twin = mesh.topology.twin[to_index(he)];
  const Stored<std::int32_t>& normal = mesh.topology.normal;
  if (twin < 0 || normal[to_index(he)] != normal[to_index(next_half_edge(twin))] ||
      normal[to_index(next_half_edge(he))] != normal[to_index(twin)])
    return {};
  const double own[3] = {s.u(), s.v, s.w};
  double b[3] = {0.0, 0.0, 0.0};
  b[next_half_edge(twin) % 3] = own[(corner + 1) % 3];
  b[twin % 3] = own[(corner + 2) % 3];
  return from_weights(twin / 3, b);
}

}  // namespace

SmoothPoint smooth_at(const Mesh::Impl& mesh, const SurfacePoint& s, const Vec3& p) noexcept {
  return Facet(mesh, s.triangle).evaluate(s, p);
}

SmoothPoint smooth_project(const Mesh::Impl& mesh, const SurfacePoint& start, const Vec3& p) noexcept {
  SurfacePoint s = start;
  std::int32_t previous = -1;
  for (int i = 0; i < kMaxWalk; ++i) {
    const Facet facet(mesh, s.triangle);
    if (!facet.solve(s, p)) return {};
    const int corner = exit_corner(s);
    if (corner < 0) return facet.evaluate(s, p);
    const SurfacePoint edge = onto_edge(s, corner);
    const SurfacePoint next = across(mesh, edge, corner);
    if (next.triangle < 0) return {};
    if (next.triangle == previous) return facet.evaluate(edge, p);  // the solution is on the edge itself
    previous = s.triangle;
    s = next;
  }
  return {};
}

}  // namespace palpate::scene
