#include "palpate/scene/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "palpate/scene/extent.hpp"
#include "palpate/scene/mesh_impl.hpp"
#include "palpate/scene/topology.hpp"
#include "palpate/scene/weld.hpp"
#include "palpate/scene/winding.hpp"
#include "palpate/types/index.hpp"

namespace palpate::scene {
namespace {

/// Builds topology and BVH, which are independent, on one thread each if a second thread is available.
void build_indices(Mesh::Impl& m, Winding& winding) {
  const auto topology = [&] {
    m.topology = build_topology(m.vertices, m.triangles);
    winding = check_orientation(m.vertices, m.triangles, m.topology);
  };
  std::thread helper;
  try {
    helper = std::thread(topology);
  } catch (const std::system_error&) {
    topology();
  }
  m.bvh = build_bvh(m.vertices, m.triangles);
  if (helper.joinable()) helper.join();
}

/// Drops triangles with three collinear corners and a boundary edge. Others close the gap of a T-junction and are kept.
/// Returns the number of dropped triangles.
std::size_t drop_flat(Mesh::Impl& m) {
  const Topology& topology = m.topology;
  std::vector<bool> drop(m.triangles.size() / 3, false);
  std::size_t dropped = 0;
  for (const std::int32_t he : topology.rims) {
    const std::int32_t c = he / 3 * 3;
    const Vec3 a = m.corner(c);
    if (drop[to_index(he / 3)] || (m.corner(c + 1) - a).cross(m.corner(c + 2) - a).squaredNorm() > 0.0) continue;
    drop[to_index(he / 3)] = true;
    ++dropped;
  }
  if (dropped == 0) return 0;
  std::vector<std::int32_t> triangles = m.triangles.take();
  std::size_t kept = 0;
  for (std::size_t t = 0; t < drop.size(); ++t) {
    if (drop[t]) continue;
    for (std::size_t c = 0; c < 3; ++c) triangles[3 * kept + c] = triangles[3 * t + c];
    ++kept;
  }
  triangles.resize(3 * kept);
  m.triangles = std::move(triangles);
  return dropped;
}

/// Builds the indices and repairs the mesh, until there is nothing left to repair. A mesh without defects is indexed
/// once.
void build_and_repair(Mesh::Impl& m, MeshReport& r) {
  for (;;) {
    Winding winding;
    build_indices(m, winding);
    const std::size_t flat = m.topology.flat_triangles > 0 ? drop_flat(m) : 0;
    r.degenerate += flat;
    if (m.triangles.empty())
      throw std::invalid_argument("mesh: all triangles are degenerate (three corners on a line); export it again");
    if (flat > 0) continue;
    r.flipped += winding.flipped;
    r.inverted += winding.inverted;
    r.two_sided &= winding.two_sided;
    r.components = winding.components;
    r.volume = winding.volume;
    if (winding.flip.empty()) return;
    std::vector<std::int32_t> triangles = m.triangles.take();
    flip(triangles, winding.flip);
    m.triangles = std::move(triangles);
  }
}

/// Fills in the parts of the report that describe the final mesh.
void complete(MeshReport& r, const Mesh::Impl& m) {
  r.vertices = m.vertices.size() / 3;
  r.triangles = m.triangles.size() / 3;
  r.flat = m.topology.flat_triangles;
  r.boundary_edges = m.topology.rims.size();
  r.branching_edges = m.topology.branching_edges;
  r.inconsistent_edges = m.topology.inconsistent_pairs.size();
  r.closed = m.topology.closed;
  r.lowest = r.highest = Vec3(m.vertices.data());
  for (std::size_t i = 0; i < m.vertices.size(); i += 3) {
    r.lowest = r.lowest.cwiseMin(Vec3(&m.vertices[i]));
    r.highest = r.highest.cwiseMax(Vec3(&m.vertices[i]));
  }
}

Feature feature_of(const BvhHit& hit) {
  // On the edge opposite corner 0 the weights are 1 - t and t, so the remaining u is a rounding error.
  const double u = 1.0 - hit.v - hit.w;
  const int zeros = (hit.v <= 0.0 ? 1 : 0) + (hit.w <= 0.0 ? 1 : 0) + (u <= 1e-15 ? 1 : 0);
  return zeros == 0 ? Feature::face : (zeros == 1 ? Feature::edge : Feature::vertex);
}

Vec3 face_normal(const Mesh::Impl& m, std::int32_t half_edge) {
  const std::int32_t c = half_edge / 3 * 3;
  const Vec3 a = m.corner(c);
  return (m.corner(c + 1) - a).cross(m.corner(c + 2) - a).normalized();
}

/// Angle-weighted normal at a vertex. Its sign distinguishes inside from outside (Baerentzen and Aanaes 2005).
Vec3 vertex_normal(const Mesh::Impl& m, std::int32_t start) {
  Vec3 sum = Vec3::Zero();
  const auto take = [&](std::int32_t he) {
    const Vec3 p = m.corner(he), e1 = m.corner(next_half_edge(he)) - p, e2 = m.corner(previous_half_edge(he)) - p;
    sum += std::atan2(e1.cross(e2).norm(), e1.dot(e2)) * face_normal(m, he);
  };
  take(start);
  for (std::int32_t he = m.topology.twin[to_index(previous_half_edge(start))]; he != start;
       he = m.topology.twin[to_index(previous_half_edge(he))]) {
    if (he < 0) {  // boundary edge: the rest of the fan is visited in the other direction
      for (std::int32_t back = m.topology.twin[to_index(start)]; back >= 0;
           back = m.topology.twin[to_index(next_half_edge(back))])
        take(next_half_edge(back));
      break;
    }
    take(he);
  }
  return sum.normalized();
}

Vec3 feature_normal(const Mesh::Impl& m, const BvhHit& hit, Feature feature) {
  const std::int32_t c = 3 * hit.triangle;
  const double b[3] = {1.0 - hit.v - hit.w, hit.v, hit.w};
  if (feature == Feature::vertex)
    return vertex_normal(m, c + static_cast<std::int32_t>(std::max_element(b, b + 3) - b));
  const Vec3 n = face_normal(m, c);
  if (feature == Feature::face) return n;
  const std::int32_t opposite = static_cast<std::int32_t>(std::min_element(b, b + 3) - b);
  const std::int32_t twin = m.topology.twin[to_index(c + (opposite + 1) % 3)];
  return twin < 0 ? n : Vec3((n + face_normal(m, twin)).normalized());
}

}  // namespace

Mesh::Mesh() : impl_(std::make_unique<Impl>()) {}
Mesh::~Mesh() = default;

std::shared_ptr<const Mesh> Mesh::build(std::span<const double> vertices, std::span<const std::int32_t> triangles) {
  return build(weld(vertices, triangles));
}

std::shared_ptr<const Mesh> Mesh::build(Welded welded) {
  std::shared_ptr<Mesh> mesh(new Mesh);
  Impl& m = *mesh->impl_;
  m.vertices = std::move(welded.vertices);
  m.triangles = std::move(welded.triangles);
  m.report.degenerate = welded.degenerate;
  m.report.duplicate = welded.duplicate;
  require_extent(m.vertices, m.triangles);
  build_and_repair(m, m.report);
  complete(m.report, m);
  return mesh;
}

std::size_t Mesh::triangle_count() const noexcept { return impl_->triangles.size() / 3; }
const MeshReport& Mesh::report() const noexcept { return impl_->report; }
std::span<const double> Mesh::vertices() const noexcept { return impl_->vertices; }
std::span<const std::int32_t> Mesh::triangles() const noexcept { return impl_->triangles; }

std::vector<std::int32_t> Mesh::rims() const {
  std::vector<std::int32_t> out;
  for (const std::int32_t he : impl_->topology.rims)
    out.insert(out.end(), {impl_->triangles[to_index(he)], impl_->triangles[to_index(next_half_edge(he))]});
  return out;
}

BvhHit Mesh::Impl::closest_on(std::int32_t triangle, const Vec3& p) const noexcept {
  const std::int32_t c = 3 * triangle;
  const Vec3 a = corner(c), e1 = corner(c + 1) - a, e2 = corner(c + 2) - a, ap = p - a;
  const double g11 = e1.squaredNorm(), g12 = e1.dot(e2), g22 = e2.squaredNorm(), d1 = e1.dot(ap), d2 = e2.dot(ap);
  BvhHit best{std::numeric_limits<double>::infinity(), 0.0, 0.0, triangle};
  const auto consider = [&](double v, double w) {
    const double distance2 = (ap - v * e1 - w * e2).squaredNorm();
    if (distance2 < best.distance2) best = {distance2, v, w, triangle};
  };
  const double det = g11 * g22 - g12 * g12;
  const double v = (g22 * d1 - g12 * d2) / det, w = (g11 * d2 - g12 * d1) / det;
  if (det > 0.0 && v > 0.0 && w > 0.0 && v + w < 1.0) {
    consider(v, w);
    return best;
  }
  const auto clamped = [](double x, double y) { return y > 0.0 ? std::clamp(x / y, 0.0, 1.0) : 0.0; };
  const double t = clamped(d2 - d1 + g11 - g12, g11 - 2.0 * g12 + g22);
  consider(clamped(d1, g11), 0.0);
  consider(0.0, clamped(d2, g22));
  consider(1.0 - t, t);
  return best;
}

BvhHit Mesh::Impl::closest(const Vec3& p, double max_distance, std::int32_t seed) const noexcept {
  BvhHit best{max_distance * max_distance, 0.0, 0.0, -1};
  if (seed >= 0) {
    const BvhHit seeded = closest_on(seed, p);
    if (seeded.distance2 < best.distance2) best = seeded;
  }
  return bvh_closest(bvh, p.data(), best);
}

ClosestPoint Mesh::closest(const Vec3& p, double max_distance) const noexcept { return closest(p, max_distance, -1); }

ClosestPoint Mesh::closest(const Vec3& p, double max_distance, int seed) const noexcept {
  return closest_point(impl_->closest(p, max_distance, seed));
}

ClosestPoint Mesh::closest_point(const BvhHit& hit) const noexcept {
  ClosestPoint out;
  if (hit.triangle < 0) return out;
  out.distance = std::sqrt(hit.distance2);
  out.point = impl_->position({hit.triangle, hit.v, hit.w});
  out.feature = feature_of(hit);
  out.normal = feature_normal(*impl_, hit, out.feature);
  out.triangle = hit.triangle;
  return out;
}

Nearest Mesh::nearest(const Vec3& p) const noexcept {
  int seed = -1;
  return nearest(p, seed);
}

Nearest Mesh::nearest(const Vec3& p, int& seed) const noexcept {
  const ClosestPoint c = closest(p, std::numeric_limits<double>::infinity(), seed);
  seed = c.triangle;
  return sided(p, c);
}

Nearest Mesh::sided(const Vec3& p, const ClosestPoint& c) const noexcept {
  const bool inside = impl_->report.closed && c.normal.dot(p - c.point) < 0.0;
  return {inside ? -c.distance : c.distance, c.point, c.normal};
}

Nearest Mesh::nearest_or_far(const Vec3& p, double exact_within) const noexcept {
  const BvhHit hit = bvh_closest(impl_->bvh, p.data(), {kExact, 0.0, 0.0, -1}, exact_within);
  const double distance = std::sqrt(hit.distance2), bound = far_bound(distance, exact_within);
  if (hit.triangle < 0 || distance <= exact_within) return sided(p, closest_point(hit));
  const Vec3 point = impl_->position({hit.triangle, hit.v, hit.w}), away = (p - point) / distance;
  // No triangle lies within `bound` of p, so p and a place almost that far towards the point found are on one side. The
  // normal at that place's nearest point tells the side; the normal at the point found does not, if another is nearer.
  const bool inside = impl_->report.closed && nearest(p - 0.95 * bound * away).distance < 0.0;
  return inside ? Nearest{-bound, point, -away} : Nearest{bound, point, away};
}

double Mesh::sweep(const Vec3& a, const Vec3& b, double radius) const noexcept {
  const double length = (b - a).norm();
  double travelled = 0.0;
  std::int32_t seed = -1;
  // At each position of the centre, the distance to the nearest triangle bounds the next safe step.
  for (int i = 0; i < 64 && travelled < length; ++i) {
    const BvhHit hit = impl_->closest(a + travelled / length * (b - a), length - travelled + radius, seed);
    if (hit.triangle < 0) return length;
    const double step = std::sqrt(hit.distance2) - radius;
    if (step <= 0.05 * radius) break;
    seed = hit.triangle;
    travelled += step;
  }
  return std::min(travelled, length);
}

bool Mesh::contains(const Vec3& p) const noexcept { return nearest(p).distance < 0.0; }

}  // namespace palpate::scene
