#include "palpate/clouds/point_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "palpate/scene/extent.hpp"
#include "palpate/types/ldlt.hpp"

namespace palpate::clouds {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr double kNothing = 1e3;       // distance from a surface without points [m]
constexpr int kProjections = 8;        // projections of a query at most
constexpr double kConverged = 2e-7;    // displacement of the foot point at which the projection ends [m]
constexpr double kFarAway = 4.0;       // [support] farther queries use the nearest point and its normal
constexpr double kBehind = 0.5;        // tangent of the angle within which a far query is behind the nearest point
constexpr double kFlat = 1e-5;         // curvature times support below which the sphere is a plane
constexpr double kNormalReach = 0.6;   // [support] radius of the planes that give normals
constexpr double kColumn = 0.6;        // [voxel] distance between two points of the smoothed layer at least
constexpr double kQueryShare = 0.6;    // [support] radius of the fit at a query
constexpr std::size_t kMatches = 500;  // points that determine a displacement
constexpr int kMatchProjections = 2;   // projections of such a point, which is near the surface
constexpr int kMinMatches = 30;        // fewer matches determine nothing
constexpr double kMaxShift = 0.03;     // larger displacements between two frames are not searched for [m]
constexpr double kPrior = 0.03;        // [matches] keeps the displacement at zero where the shape is ambiguous

void require_valid(const PointInput& input, const PointSurfaceOptions& o) {
  for (const double x : {o.voxel, o.support, o.bridge, o.thickness})
    if (!(x > 0.0) || !std::isfinite(x))
      throw std::invalid_argument("voxel, support, bridge and thickness must be positive lengths in metres, got " +
                                  std::to_string(x));
  if (input.points.size() % 3 != 0 || (!input.normals.empty() && input.normals.size() != input.points.size()))
    throw std::invalid_argument("a cloud needs points (n, 3), and as many normals");
  for (const double x : input.points)
    if (!(std::abs(x) <= scene::kMaxCoordinate))
      throw std::invalid_argument("points of a cloud must be finite, within 1e9 m");
  for (const double x : input.normals)
    if (!std::isfinite(x)) throw std::invalid_argument("normals of a cloud must be finite");
  if (input.viewpoint && !input.viewpoint->allFinite()) throw std::invalid_argument("viewpoint must be finite");
}

/// Radius within which the smoothed points shape the surface at a query [m].
double query_support(const PointSurfaceOptions& o) noexcept { return std::max(kQueryShare * o.support, 2.5 * o.voxel); }

/// Algebraic sphere u_c + u_l . y + u_q |y|^2 = 0, with y relative to the centre of the weights.
struct AlgebraicSphere {
  double c = 0.0;
  Vec3 l = Vec3::Zero();
  double q = 0.0;

  [[nodiscard]] Vec3 gradient(const Vec3& y) const noexcept { return l + 2.0 * q * y; }
  /// The point of the sphere nearest to y.
  [[nodiscard]] Vec3 project(const Vec3& y, double support) const noexcept {
    const double slope = l.norm();
    if (std::abs(q) * support < kFlat * slope) return y - (c + l.dot(y)) / (slope * slope) * l;
    const Vec3 centre = -0.5 / q * l;
    const double radius = std::sqrt(std::max(centre.squaredNorm() - c / q, 0.0));
    const Vec3 out = y - centre;
    const double length = out.norm();
    return length > 0.0 ? Vec3(centre + radius / length * out) : y;
  }
};

/// Sums of the weighted points and normals around x.
struct Sums {
  double w = 0.0, pn = 0.0, pp = 0.0;
  Vec3 p = Vec3::Zero(), n = Vec3::Zero();
  std::uint32_t nearest = 0;

  /// The sphere of the closed form of 2008, with unit weight of the normals.
  [[nodiscard]] AlgebraicSphere sphere() const noexcept {
    AlgebraicSphere s;
    const double spread = pp - p.squaredNorm() / w;
    s.q = spread > 1e-12 * w ? 0.5 * (pn - p.dot(n) / w) / spread : 0.0;
    s.l = (n - 2.0 * s.q * p) / w;
    s.c = -(s.l.dot(p) + s.q * pp) / w;
    return s;
  }
};

/// Sums in single precision, which is 1e-6 of the support.
Sums sum_near(const PointGrid& grid, const Vec3& x, const Vec3& side, double support) noexcept {
  using Four = Eigen::Vector4f;
  const Eigen::Vector3f at = x.cast<float>(), front = side.cast<float>();
  const auto inverse = static_cast<float>(1.0 / (support * support));
  Four p = Four::Zero(), n = Four::Zero();
  float total = 0.0F, pn = 0.0F, pp = 0.0F, nearest2 = std::numeric_limits<float>::infinity();
  Sums out;
  grid.visit_near(x, support, [&](const GridPoint& s, std::uint32_t i) {
    const Four d(s.p[0] - at.x(), s.p[1] - at.y(), s.p[2] - at.z(), 0.0F);
    const Eigen::Map<const Four, Eigen::Aligned16> normal(s.n);
    const float d2 = d.x() * d.x() + d.y() * d.y() + d.z() * d.z(), rest = 1.0F - d2 * inverse;
    if (!(rest > 0.0F)) return;
    if (!(s.n[0] * front.x() + s.n[1] * front.y() + s.n[2] * front.z() > 0.0F)) return;
    if (d2 < nearest2) {
      nearest2 = d2;
      out.nearest = i;
    }
    const float w = s.weight * rest * rest * rest * rest;
    total += w;
    p += w * d;
    n += w * normal;
    pn += w * (d.x() * s.n[0] + d.y() * s.n[1] + d.z() * s.n[2]);
    pp += w * d2;
  });
  out.w = static_cast<double>(total);
  out.p = p.head<3>().cast<double>();
  out.n = n.head<3>().cast<double>();
  out.pn = static_cast<double>(pn);
  out.pp = static_cast<double>(pp);
  return out;
}

scene::Bvh hierarchy(const PointGrid& grid) {
  const auto& points = grid.points();
  std::vector<double> p(3 * points.size());
  std::vector<std::int32_t> corners(3 * points.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    p[i] = static_cast<double>(points[i / 3].p[i % 3]);
    corners[i] = static_cast<std::int32_t>(i / 3);
  }
  return points.empty() ? scene::Bvh{} : scene::build_bvh(p, corners);
}

/// Marks the points that lie within `width` of the line through x along n, on the same side of the sheet.
void mark_column(const PointGrid& grid, const Vec3& x, const Vec3& n, double height, double width,
                 std::vector<char>& marked) noexcept {
  grid.visit_near(x, height, [&](const GridPoint& s, std::uint32_t i) {
    const Vec3 d(s.p[0] - x.x(), s.p[1] - x.y(), s.p[2] - x.z());
    const double along = d.dot(n);
    if (d.squaredNorm() - along * along < width * width && n.dot(Vec3(s.n[0], s.n[1], s.n[2])) > 0.0) marked[i] = 1;
  });
}

/// The points moved onto the surfaces fitted around them, with the normals of these surfaces. Noise scatters the
/// averaged points over several layers; afterwards they are one layer, which a query fits within a smaller radius.
/// Points that would come to lie next to one that was moved already are left out.
PointGrid smoothed(const PointGrid& noisy, const PointSurfaceOptions& options) {
  std::vector<double> p, n;
  std::vector<char> covered(noisy.points().size(), 0);
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (covered[i] != 0) continue;
    const GridPoint& s = noisy.points()[i];
    const Vec3 start(s.p[0], s.p[1], s.p[2]), side(s.n[0], s.n[1], s.n[2]);
    const Sums sums = sum_near(noisy, start, side, options.support);
    if (!(sums.w > 0.0)) continue;
    const AlgebraicSphere sphere = sums.sphere();
    const Vec3 move = sphere.project(Vec3::Zero(), options.support), normal = sphere.gradient(move).normalized();
    if (!normal.allFinite() || !(move.norm() <= options.support)) continue;
    const Vec3 x = start + move;
    mark_column(noisy, x, normal, 0.5 * options.support, kColumn * options.voxel, covered);
    for (int k = 0; k < 3; ++k) {
      p.push_back(x[k] + noisy.origin()[k]);
      n.push_back(normal[k]);
    }
  }
  return {p, n, std::nullopt, options.voxel, query_support(options)};
}

PointGrid checked_grid(const PointInput& input, const PointSurfaceOptions& options) {
  require_valid(input, options);
  const PointGrid noisy(input.points, input.normals, input.viewpoint, options.voxel, kNormalReach * options.support);
  PointGrid smooth = smoothed(noisy, options);
  smooth.set_rejected(noisy.rejected());
  return smooth;
}

}  // namespace

/// Foot point of a query on the fitted surface, relative to the grid's origin.
struct PointSurface::Foot {
  Vec3 x = Vec3::Zero(), n = Vec3::UnitZ();  // position [m] and outward unit normal
  std::uint32_t nearest = 0;                 // index of the averaged point nearest to x
};

PointSurface::PointSurface(const PointInput& input, const PointSurfaceOptions& options, const PointSurface* continues)
    : scene::Surface(continues == nullptr ? 0 : continues->id()),
      options_(options),
      grid_(checked_grid(input, options)),
      bvh_(hierarchy(grid_)) {}

/// Projects p repeatedly onto the sphere fitted at its present foot point, beginning at the averaged point `start`.
PointSurface::Foot PointSurface::foot(const Vec3& p, std::int32_t start, int projections) const noexcept {
  const GridPoint& first = grid_.points()[static_cast<std::size_t>(start)];
  const Vec3 side(first.n[0], first.n[1], first.n[2]);
  Foot foot{Vec3(first.p[0], first.p[1], first.p[2]), side, static_cast<std::uint32_t>(start)};
  const double support = query_support(options_), far = kFarAway * options_.support;
  if ((p - foot.x).squaredNorm() > far * far) {  // the tangent plane at the nearest point is enough
    const double s = (p - foot.x).dot(side);
    const Vec3 on_plane = p - s * side;
    if (s >= 0.0 || (on_plane - foot.x).norm() > kBehind * -s) foot.x = on_plane;
    return foot;
  }
  const double step = 0.5 * support;
  for (int i = 0; i < projections; ++i) {
    const Sums sums = sum_near(grid_, foot.x, side, support);
    if (!(sums.w > 0.0)) break;
    const AlgebraicSphere sphere = sums.sphere();
    Vec3 move = sphere.project(p - foot.x, support);
    const double length = move.norm();
    if (!std::isfinite(length)) break;
    if (length > step) move *= step / length;
    foot.n = sphere.gradient(move).normalized();
    foot.nearest = sums.nearest;
    foot.x += move;
    if (length < kConverged) break;
  }
  return foot;
}

scene::Nearest PointSurface::nearest(const Vec3& p) const noexcept {
  if (grid_.points().empty()) return {kNothing, Vec3::Zero(), Vec3::UnitZ()};
  const Vec3 q = p - grid_.origin();
  const scene::BvhHit hit = bvh_closest(bvh_, q.data(), {kUnlimited, 0.0, 0.0, -1});
  const Foot at = foot(q, std::max(hit.triangle, 0), kProjections);
  const GridPoint& c = grid_.points()[at.nearest];

  // Beyond the rim the nearest point of the surface is on the rim.
  Vec3 off = at.x - Vec3(c.p[0], c.p[1], c.p[2]);
  off -= off.dot(at.n) * at.n;
  const double tangential = off.norm(), beyond = tangential - options_.bridge;
  const double s = (q - at.x).dot(at.n);
  if (beyond <= 0.0) {
    const double behind = -(s + options_.thickness);
    if (s >= behind) return {s, at.x + grid_.origin(), at.n};
    return {behind, at.x - options_.thickness * at.n + grid_.origin(), -at.n};
  }
  const Vec3 rim = at.x - beyond / tangential * off - std::clamp(-s, 0.0, options_.thickness) * at.n;
  const Vec3 out = q - rim;
  const double away = out.norm();
  return {away, rim + grid_.origin(), away > 0.0 ? Vec3(out / away) : at.n};
}

std::optional<Vec3> PointSurface::shift_to(std::span<const double> points, const Vec3& centre, double radius) const {
  if (grid_.points().empty()) return std::nullopt;
  std::vector<Vec3> near;
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
    const Vec3 p(&points[i]);
    if ((p - centre).squaredNorm() < radius * radius) near.push_back(p);
  }
  const std::size_t stride = std::max<std::size_t>(1, near.size() / kMatches);
  Vec3 shift = Vec3::Zero();
  double scale = kMaxShift;  // residuals beyond it are mismatches [m]
  std::vector<double> sizes;
  for (int iteration = 0; iteration < 3; ++iteration) {
    Mat3 A = Mat3::Zero();
    Vec3 b = Vec3::Zero();
    int matches = 0;
    sizes.clear();
    for (std::size_t i = 0; i < near.size(); i += stride) {
      const Vec3 p = near[i] - shift;
      const Vec3 q = p - grid_.origin();
      const scene::BvhHit hit =
          bvh_closest(bvh_, q.data(), {(scale + options_.bridge) * (scale + options_.bridge), 0.0, 0.0, -1});
      if (hit.triangle < 0) continue;
      const Foot at = foot(q, hit.triangle, kMatchProjections);
      const double r = (q - at.x).dot(at.n);
      if (std::abs(r) > scale || (q - at.x - r * at.n).norm() > options_.bridge) continue;
      ++matches;
      sizes.push_back(std::abs(r));
      A += at.n * at.n.transpose();
      b += r * at.n;
    }
    if (matches < kMinMatches) return std::nullopt;
    A.diagonal().array() += kPrior * matches;
    shift += solve_ldlt(A, b);
    std::nth_element(sizes.begin(), sizes.begin() + matches / 2, sizes.end());
    scale = std::clamp(4.0 * sizes[static_cast<std::size_t>(matches / 2)], 1e-3, scale);
  }
  if (!(shift.norm() < kMaxShift)) return std::nullopt;
  return shift;
}

}  // namespace palpate::clouds
