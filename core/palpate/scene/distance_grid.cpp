#include "palpate/scene/distance_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "palpate/scene/mesh.hpp"

namespace palpate::scene {
namespace {

constexpr double kSteepest = 1.5;        // [-] largest allowed change of the values per metre; a distance has 1
constexpr double kRidgeSuspect = 0.995;  // [-] points with a shorter gradient may lie near a ridge; a distance has 1
constexpr double kRidge = 0.9;           // [-] points with a shorter gradient lie near a ridge
constexpr double kWrongWall = 0.05;      // [spacing] excess over the sampled distance that marks a wrong wall
constexpr int kFootSteps = 8;            // iterations of the search for a foot point
constexpr double kClose = 1e-7;          // [spacing] convergence tolerance of a foot point

/// Catmull-Rom weights w of four neighbours, and their derivatives d, at t in [0, 1] between the middle two.
struct Weights {
  std::array<double, 4> w, d;

  explicit Weights(double t)
      : w{0.5 * t * (-1.0 + t * (2.0 - t)), 0.5 * (2.0 + t * t * (-5.0 + 3.0 * t)),
          0.5 * t * (1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * t * (t - 1.0)},
        d{0.5 * (-1.0 + t * (4.0 - 3.0 * t)), 0.5 * t * (-10.0 + 9.0 * t), 0.5 * (1.0 + t * (8.0 - 9.0 * t)),
          0.5 * t * (-2.0 + 3.0 * t)} {}
};

void require(bool good, const std::string& otherwise) {
  if (!good) throw std::invalid_argument(otherwise);
}

/// Largest change between neighbouring nodes along an axis with n nodes, which are `stride` apart in memory.
float largest_change(std::span<const float> values, std::size_t n, std::size_t stride) {
  float largest = 0.0F;
  for (std::size_t start = 0; start < values.size(); start += n * stride) {
    const float* v = &values[start];
    for (std::size_t i = 0; i < (n - 1) * stride; ++i) largest = std::max(largest, std::abs(v[i + stride] - v[i]));
  }
  return largest;
}

}  // namespace

void sample(const Mesh& mesh, const Vec3& origin, const Vec3& spacing, const std::array<std::size_t, 3>& nodes,
            std::span<float> values) noexcept {
  std::size_t at = 0;
  // Start triangles of the queries: nearest to the first node of the previous plane, to the first node of the previous
  // row, and to the previous node.
  std::array<int, 3> seed{-1, -1, -1};
  for (std::size_t i = 0; i < nodes[0]; ++i) {
    seed[1] = seed[0];
    for (std::size_t j = 0; j < nodes[1]; ++j) {
      seed[2] = seed[1];
      for (std::size_t k = 0; k < nodes[2]; ++k) {
        const Vec3 ijk(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k));
        values[at++] = static_cast<float>(mesh.nearest(origin + spacing.cwiseProduct(ijk), seed[2]).distance);
        if (k == 0) seed[1] = seed[2];
      }
      if (j == 0) seed[0] = seed[1];
    }
  }
}

DistanceGrid::DistanceGrid(const Vec3& origin, const Vec3& spacing, const std::array<std::size_t, 3>& nodes,
                           std::span<const float> values)
    : lowest_(origin), spacing_(spacing), nodes_(nodes), padded_{nodes[0] + 2, nodes[1] + 2, nodes[2] + 2} {
  const std::string size =
      std::to_string(nodes[0]) + " x " + std::to_string(nodes[1]) + " x " + std::to_string(nodes[2]);
  require(origin.allFinite(), "the origin must be finite");
  require(spacing.allFinite() && spacing.minCoeff() > 0.0, "the spacing must be positive lengths in metres");
  require(*std::min_element(nodes.begin(), nodes.end()) >= 4, "at least 4 nodes along each axis, got " + size);
  require(values.size() == nodes[0] * nodes[1] * nodes[2],
          size + " nodes want as many values, got " + std::to_string(values.size()));
  require(std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }), "values must be finite");
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  require(*least < 0.0F && *most > 0.0F, "no surface inside: values go from " + std::to_string(*least) + " to " +
                                             std::to_string(*most) + " m, a surface is where they cross zero");
  for (int i = 0; i < 3; ++i)
    highest_[i] = origin[i] + spacing[i] * static_cast<double>(nodes[static_cast<std::size_t>(i)] - 1);

  const std::array<std::size_t, 3> stride{nodes[1] * nodes[2], nodes[2], 1};
  double steepest = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    const float change = largest_change(values, nodes[a], stride[a]);
    steepest = std::max(steepest, static_cast<double>(change) / spacing[static_cast<Eigen::Index>(a)]);
  }
  require(steepest <= kSteepest, "values change by up to " + std::to_string(steepest) +
                                     " m per metre, a distance by 1 at most: a wrong unit, or no distance");
  add_border(values);
}

/// Adds a border of one node on each side by linear extrapolation, so that every cell has four neighbours along each
/// axis.
void DistanceGrid::add_border(std::span<const float> values) {
  value_.resize(padded_[0] * padded_[1] * padded_[2]);
  const auto at = [this](std::size_t i, std::size_t j, std::size_t k) -> float& {
    return value_[(i * padded_[1] + j) * padded_[2] + k];
  };
  const auto line = [](float near, float next) { return 2.0F * near - next; };
  const auto [nx, ny, nz] = nodes_;
  for (std::size_t i = 1; i <= nx; ++i)
    for (std::size_t j = 1; j <= ny; ++j) {
      std::copy_n(&values[((i - 1) * ny + j - 1) * nz], nz, &at(i, j, 1));
      at(i, j, 0) = line(at(i, j, 1), at(i, j, 2));
      at(i, j, nz + 1) = line(at(i, j, nz), at(i, j, nz - 1));
    }
  for (std::size_t i = 1; i <= nx; ++i)
    for (std::size_t k = 0; k < padded_[2]; ++k) {
      at(i, 0, k) = line(at(i, 1, k), at(i, 2, k));
      at(i, ny + 1, k) = line(at(i, ny, k), at(i, ny - 1, k));
    }
  for (std::size_t j = 0; j < padded_[1]; ++j)
    for (std::size_t k = 0; k < padded_[2]; ++k) {
      at(0, j, k) = line(at(1, j, k), at(2, j, k));
      at(nx + 1, j, k) = line(at(nx, j, k), at(nx - 1, j, k));
    }
}

double DistanceGrid::value(const Vec3& p, Vec3& gradient) const noexcept {
  std::array<std::size_t, 3> cell;
  Vec3 t;
  for (Eigen::Index a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const double last = static_cast<double>(nodes_[i] - 2);
    const double u = (std::clamp(p[a], lowest_[a], highest_[a]) - lowest_[a]) / spacing_[a];
    const double whole = std::clamp(std::floor(u), 0.0, last);
    cell[i] = static_cast<std::size_t>(whole);
    t[a] = u - whole;
  }
  const Weights x(t[0]), y(t[1]), z(t[2]);
  double value = 0.0;
  gradient.setZero();
  for (std::size_t i = 0; i < 4; ++i) {
    double plane = 0.0, plane_y = 0.0, plane_z = 0.0;
    for (std::size_t j = 0; j < 4; ++j) {
      const float* v = &value_[((cell[0] + i) * padded_[1] + cell[1] + j) * padded_[2] + cell[2]];
      double row = 0.0, row_z = 0.0;
      for (std::size_t k = 0; k < 4; ++k) {
        row += z.w[k] * static_cast<double>(v[k]);
        row_z += z.d[k] * static_cast<double>(v[k]);
      }
      plane += y.w[j] * row;
      plane_y += y.d[j] * row;
      plane_z += y.w[j] * row_z;
    }
    value += x.w[i] * plane;
    gradient += Vec3(x.d[i] * plane, x.w[i] * plane_y, x.w[i] * plane_z);
  }
  gradient = gradient.cwiseQuotient(spacing_);
  return value;
}

/// Foot point of the perpendicular from p on the zero level, by repeated projection onto the tangent plane, beginning
/// at `start`.
DistanceGrid::Foot DistanceGrid::foot(const Vec3& p, const Vec3& start) const noexcept {
  const double close = kClose * spacing_.minCoeff();
  Foot out;
  out.q = start;
  double before = std::numeric_limits<double>::infinity();
  for (int step = 0; step < kFootSteps; ++step) {
    Vec3 g;
    const double v = value(out.q, g);
    const double length = g.norm();
    if (!(length > 0.1)) return out;  // the distance is flat: there is no wall
    out.n = g / length;
    const Vec3 next = (p - out.n * (out.n.dot(p - out.q) + v / length)).cwiseMax(lowest_).cwiseMin(highest_);
    const double moved = (next - out.q).norm();
    out.q = next;
    // At the boundary of the grid the clamped projection may end away from the zero level.
    out.found = moved < 1e-2 * spacing_.minCoeff() && std::abs(v) < 0.1 * spacing_.minCoeff();
    if (moved <= close || moved > 0.9 * before) break;
    before = moved;
  }
  return out;
}

/// Moves q towards the zero level by two Newton steps.
Vec3 DistanceGrid::onto_wall(Vec3 q) const noexcept {
  for (int step = 0; step < 2; ++step) {
    Vec3 g;
    const double v = value(q, g), length2 = g.squaredNorm();
    if (length2 > 0.01) q = (q - v / length2 * g).cwiseMax(lowest_).cwiseMin(highest_);
  }
  return q;
}

/// Nearest surface point for a point p inside the grid.
Nearest DistanceGrid::wall(const Vec3& p) const noexcept {
  Vec3 g;
  const double v = value(p, g);
  const double side = v < 0.0 ? -1.0 : 1.0, length = g.norm();
  Foot best;
  if (length >= kRidge) best = foot(p, p - v / (length * length) * g);
  if (!best.found || length < kRidgeSuspect) {
    // Near a ridge the gradient belongs to no wall. The search starts from two cells away in each direction instead.
    double least = best.found ? (p - best.q).norm() : std::numeric_limits<double>::infinity();
    for (int k = 0; k < 6; ++k) {
      const Vec3 aside = p + (k % 2 == 0 ? 2.0 : -2.0) * spacing_[k / 2] * Vec3::Unit(k / 2);
      Vec3 ga;
      const double va = value(aside, ga), la = ga.norm();
      if (!(la >= kRidge)) continue;
      const Foot candidate = foot(p, aside.cwiseMax(lowest_).cwiseMin(highest_) - va / (la * la) * ga);
      const double distance = (candidate.q - p).norm();
      if (!candidate.found || distance >= least) continue;
      least = distance;
      best = candidate;
    }
  }
  // Far from a sharp bump the search can stray to a wall that is farther away than the sampled distance.
  const double max_distance = std::abs(v) + kWrongWall * spacing_.minCoeff();
  if (best.found && length >= kRidge && (p - best.q).norm() > max_distance) {
    const Vec3 q = onto_wall(p - v / length * g);
    const double distance = (p - q).norm();
    if (distance > 0.0 && distance < (p - best.q).norm()) best = {q, side / distance * (p - q), true};
  }
  if (!best.found) {  // no foot point was found: the sampled distance and its gradient are used
    best.n = length > 0.0 ? Vec3(g / length) : Vec3::UnitZ();
    return {v, p - v * best.n, best.n};
  }
  return {side * (p - best.q).norm(), best.q, best.n};
}

Nearest DistanceGrid::nearest(const Vec3& p) const noexcept {
  const Vec3 c = p.cwiseMax(lowest_).cwiseMin(highest_);
  Nearest found = wall(c);
  const double outside = (p - c).norm();
  if (outside > 0.0) {
    const Vec3 towards = found.distance > 0.0 ? Vec3(p - found.point) : Vec3(p - c);
    if (found.distance <= 0.0) found.point = c;
    found.distance = std::hypot(outside, std::max(found.distance, 0.0));
    found.normal = towards.normalized();
    return found;
  }
  int axis = 0, end = 0;
  const double low = (p - lowest_).minCoeff(&axis), high = (highest_ - p).minCoeff(&end);
  if (found.distance >= -std::min(low, high)) return found;
  // The solid ends at the boundary of the grid, which is nearer than the zero level.
  found.distance = -std::min(low, high);
  found.point = p;
  found.normal.setZero();
  if (low <= high) {
    found.point[axis] = lowest_[axis];
    found.normal[axis] = -1.0;
  } else {
    found.point[end] = highest_[end];
    found.normal[end] = 1.0;
  }
  return found;
}

}  // namespace palpate::scene
