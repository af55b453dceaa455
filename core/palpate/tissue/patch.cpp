#include "palpate/tissue/patch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/scene/smooth.hpp"
#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kPatchReach = 14.0;          // [T] below the sphere where the weight of a point is nothing
constexpr double kCap = 0.9;                  // [R] beside the axis where the sphere becomes a cone
constexpr double kCapHeight = 0.43588989;     // [R] of the centre over this circle
constexpr double kSteep = kCap / kCapHeight;  // slope of the cone
constexpr double kInside = 1.0,
                 kWidest = 1.3;  // [R] beside the axis where the weight of a point begins to fall, and ends
constexpr double kAround = 1.6, kEdges = 1.2;  // [R], [edge] the larger one: range of the mean normal
constexpr double kFarthest = 12.0;             // [R] triangles beyond are not under the sphere
constexpr double kDense = 1.75;                // small triangles along an edge for each radius in it
constexpr double kFacing = -0.2;               // cosine to the way out below which a triangle is on another side
constexpr double kLeastCosine = 0.35;          // of a normal to the axis; a steeper one is cut
constexpr int kMostDivisions = 16;

/// Height of the tool's surface over its lowest point, at the distance r beside the axis [R].
double profile(double r) noexcept {
  return r > kCap ? 1.0 - kCapHeight + kSteep * (r - kCap) : 1.0 - std::sqrt(1.0 - r * r);
}

/// Barycentric weights (v, w) of the middles of the n^2 small triangles of a triangle.
class Subdivision {
 public:
  Subdivision() {
    for (int n = 1; n <= kMostDivisions; ++n) {
      const double step = 1.0 / n;
      for (int i = 0; i < n; ++i)
        for (int j = 0; i + j < n; ++j) {
          place_[to_index(n)].push_back({(i + 1.0 / 3.0) * step, (j + 1.0 / 3.0) * step});
          if (i + j + 1 < n) place_[to_index(n)].push_back({(i + 2.0 / 3.0) * step, (j + 2.0 / 3.0) * step});
        }
    }
  }
  using Place = std::array<double, 2>;
  [[nodiscard]] const std::vector<Place>& at(int divisions) const noexcept { return place_[to_index(divisions)]; }

 private:
  std::array<std::vector<Place>, kMostDivisions + 1> place_;
};
const Subdivision kSubdivision;

}  // namespace

Patch& Patch::operator=(const Patch& other) noexcept {
  axis_ = other.axis_;
  radius_ = other.radius_;
  divisions_ = other.divisions_;
  triangles_ = other.triangles_;
  vertices_ = other.vertices_;
  points_ = other.points_;
  turns_ = other.turns_;
  std::copy_n(other.triangle_.begin(), triangles_, triangle_.begin());
  std::copy_n(other.vertex_.begin(), vertices_, vertex_.begin());
  std::copy_n(other.point_.begin(), points_, point_.begin());
  return *this;
}

bool Patch::add_triangle(const SoftTables& tables, std::int32_t t) noexcept {
  if (triangles_ == kPatchTriangles) return false;
  Triangle added{t, {}};
  for (std::int32_t k = 0; k < 3; ++k) {
    const std::int32_t vertex = tables.rest->triangles()[to_index(3 * t + k)];
    const auto end = vertex_.begin() + vertices_;
    const auto found = std::find(vertex_.begin(), end, vertex);
    if (found == end) {
      if (vertices_ == kPatchVertices) return false;
      vertex_[to_index(vertices_++)] = vertex;
    }
    added.corner[to_index(k)] = static_cast<std::uint16_t>(found - vertex_.begin());
  }
  triangle_[to_index(triangles_++)] = added;
  return true;
}

void Patch::gather(const SoftTables& tables, const scene::Mesh::Impl& mesh, const Vec3& centre, double radius,
                   const Vec3& out, std::span<const std::int32_t> starts, std::vector<std::uint32_t>& seen,
                   std::uint32_t round) noexcept {
  radius_ = radius;
  turns_ = false;
  triangles_ = vertices_ = points_ = 0;
  const double around = std::max(kAround * radius, kEdges * tables.edge);
  const auto visit = [&](std::int32_t t, bool always) {
    if (t < 0 || seen[to_index(t)] == round) return;
    seen[to_index(t)] = round;
    const Vec3 a = mesh.corner(3 * t), b = mesh.corner(3 * t + 1), c = mesh.corner(3 * t + 2);
    const Vec3 middle = (a + b + c) / 3.0, away = middle - centre, normal = (b - a).cross(c - a);
    const double size =
        std::sqrt(std::max({(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()}));
    const double far = away.norm();
    const bool near = far < around || (far < kFarthest * radius + size &&
                                       (away - out.dot(away) * out).norm() < kWidest * radius + size);
    if (always || (near && normal.dot(out) > kFacing * normal.norm())) add_triangle(tables, t);
  };
  visit(starts.front(), true);
  for (const std::int32_t start : starts.subspan(1)) visit(start, false);
  for (int i = 0; i < triangles_; ++i)
    for (std::int32_t k = 0; k < 3; ++k) {
      const std::int32_t twin = mesh.topology.twin[to_index(3 * triangle_[to_index(i)].index + k)];
      if (twin >= 0) visit(twin / 3, false);
    }
  find_axis(mesh, centre, around, out);
  add_points(tables, mesh, centre);
}

/// Mean normal of the triangles in a ball around the sphere's centre.
void Patch::find_axis(const scene::Mesh::Impl& mesh, const Vec3& centre, double around, const Vec3& out) noexcept {
  axis_.setZero();
  for (int i = 0; i < triangles_; ++i) {
    const std::int32_t c = 3 * triangle_[to_index(i)].index;
    const Vec3 area = (mesh.corner(c + 1) - mesh.corner(c)).cross(mesh.corner(c + 2) - mesh.corner(c));
    const Vec3 middle = (mesh.corner(c) + mesh.corner(c + 1) + mesh.corner(c + 2)) / 3.0;
    const double weight = std::max(1.0 - (middle - centre).squaredNorm() / (around * around), 0.0);
    axis_ += weight * weight * area;
  }
  const double length = axis_.norm();
  axis_ = length > 0.0 ? Vec3(axis_ / length) : out;
}

void Patch::add_points(const SoftTables& tables, const scene::Mesh::Impl& mesh, const Vec3& centre) noexcept {
  divisions_ = std::clamp(static_cast<int>(std::ceil(kDense * tables.edge / radius_ - 0.05)), 1, kMostDivisions);
  const std::vector<Subdivision::Place>& places = kSubdivision.at(divisions_);
  const scene::Mesh::Impl& rest = tables.rest->impl();
  const double reach = 1.5 * radius_, reach2 = reach * reach;  // the axis turns until the next tick
  for (int i = 0; i < triangles_; ++i) {
    const std::int32_t t = triangle_[to_index(i)].index, c = 3 * t;
    triangle_[to_index(i)].slope =
        slope_of((mesh.corner(c + 1) - mesh.corner(c)).cross(mesh.corner(c + 2) - mesh.corner(c)).normalized());
    for (std::size_t k = 0; k < places.size() && points_ < kPatchPoints; ++k) {
      const scene::SurfacePoint at{t, places[k][0], places[k][1]};
      const Vec3 away = centre - mesh.position(at);
      if ((away - axis_.dot(away) * axis_).squaredNorm() > reach2) continue;
      double height = 0.0;
      if (tables.rounded) {
        const scene::SmoothPoint smooth = scene::smooth_at(rest, at, rest.position(at));
        if (smooth.found) height = -smooth.distance;
      }
      const Vec3 normal = (1.0 - at.v - at.w) * mesh.normal(c) + at.v * mesh.normal(c + 1) + at.w * mesh.normal(c + 2);
      const Vec3 slope = slope_of(normal);
      point_[to_index(points_++)] = {static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(k),
                                     static_cast<float>(height), slope.cast<float>()};
    }
  }
}

Vec3 Patch::slope_of(const Vec3& normal) const noexcept {
  return normal / std::max(normal.dot(axis_), kLeastCosine * normal.norm());
}

std::int32_t Patch::heaviest(const double* share) const noexcept {
  std::int32_t out = -1;
  double most = 0.0;
  for (int i = 0; i < triangles_; ++i) {
    const auto& corner = triangle_[to_index(i)].corner;
    const double sum = share[corner[0]] + share[corner[1]] + share[corner[2]];
    if (!(sum > most)) continue;
    most = sum;
    out = triangle_[to_index(i)].index;
  }
  return out;
}

Meeting Patch::meet(const SoftTables& tables, const Vec3& centre, const Vec3* x, Vec3* pull,
                    double* share) const noexcept {
  Meeting out;
  const double T = kSoftness * radius_;
  std::fill_n(pull, vertices_, Vec3::Zero());
  std::fill_n(share, vertices_, 0.0);
  const std::vector<Subdivision::Place>& places = kSubdivision.at(divisions_);
  double S = 0.0;
  int last = -1;
  Vec3 a = Vec3::Zero(), e1 = a, e2 = a, normal = a, turned = a;
  double area = 0.0;
  for (int i = 0; i < points_; ++i) {
    const Point& point = point_[to_index(i)];
    const Triangle& triangle = triangle_[point.triangle];
    if (point.triangle != last) {
      last = point.triangle;
      a = x[triangle.corner[0]];
      e1 = x[triangle.corner[1]] - a;
      e2 = x[triangle.corner[2]] - a;
      normal = e1.cross(e2);
      area = 0.5 * std::max(normal.dot(axis_), 0.0) / static_cast<double>(places.size());
      normal.normalize();
      if (turns_) turned = slope_of(normal) - triangle.slope;
    }
    if (!(area > 0.0)) continue;
    const double v = places[point.place][0], w = places[point.place][1];
    const Vec3 away = centre - a - v * e1 - w * e2 - static_cast<double>(point.height) * normal;
    const double h = axis_.dot(away);
    const Vec3 side = away - h * axis_;
    const double r = side.norm();
    const double s = (radius_ * (1.0 - profile(r / radius_)) - h) / T;
    if (!(s > -kPatchReach) || r > kWidest * radius_) continue;
    const double inside = std::min((kWidest - r / radius_) / (kWidest - kInside), 1.0);
    const double a2 = area * inside * inside * (3.0 - 2.0 * inside), e = std::exp(s), weight = a2 * e;
    S += weight;
    const Vec3 along = turns_ ? Vec3(point.slope.cast<double>() + turned) : Vec3(point.slope.cast<double>());
    const double b[3] = {1.0 - v - w, v, w};
    for (std::size_t k = 0; k < 3; ++k) {
      pull[triangle.corner[k]] += weight * b[k] * along;
      share[triangle.corner[k]] += weight * b[k];
    }
    out.yield += weight * tables.spreading.yield(triangle.index, b);
  }
  if (!(S > 0.0)) {
    out.depth = -radius_;
    return out;
  }
  out.depth = T * std::log(S / (2.0 * std::numbers::pi * T * (radius_ - T)));
  out.yield /= S;
  for (int i = 0; i < vertices_; ++i) {
    pull[i] /= S;
    share[i] /= S;
    out.push += pull[i];
  }
  return out;
}

}  // namespace palpate::tissue
