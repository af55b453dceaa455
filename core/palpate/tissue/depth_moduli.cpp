#include "palpate/tissue/depth_moduli.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr std::size_t kLayers = 24;        // below the surface, thinner above
constexpr double kDeepest = 8.0;           // [width] where the last one ends
constexpr double kNarrowest = 0.2;         // [width] smallest radius of contact
constexpr int kPoints = 200;               // of the integrals over a pressure
constexpr double kLow = 0.1, kHigh = 0.5;  // [radius] depths between which the modulus is taken to be linear
constexpr double kMiddle = 0.25;           // [radius] where this line is exact if its slope is limited
constexpr double kLeastGrowth = -0.1, kMostGrowth = 2.0;  // so that the tangent of the local law increases

// Exponent of the mean of materials beside each other, which act neither as parallel springs (1) nor as serial ones
// (-1); found by comparing lumps of two meshes with finite elements.
constexpr double kBeside = 0.25;

/// Pressure at a share of the radius that carries it.
using Pressure = double (*)(double);
double hertz(double r) { return std::sqrt(std::max(1.0 - r * r, 0.0)); }
double gauss(double r) { return std::exp(-12.5 * r * r); }  // five standard deviations
constexpr double kGaussReach = 5.0 * std::numbers::sqrt2;   // [width] a spread load, seen by a spread mean

double layer_end(std::size_t k) {  // [width]
  const double s = static_cast<double>(k) / static_cast<double>(kLayers);
  return kDeepest * s * s;
}

/// Displacement at a depth z below the middle of a pressure that reaches up to `reach`, up to a factor.
double sunk(Pressure pressure, double reach, double z, double poisson) {
  double sum = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const double share = (i + 0.5) / kPoints, r = reach * share, far = std::hypot(r, z);
    sum += pressure(share) * r * (z * z / (far * far * far) + 2.0 * (1.0 - poisson) / far);
  }
  return sum;
}

using Layers = std::array<double, kLayers>;
/// Share of each layer of the displacement of the surface; the last one has that of everything below, too.
Layers shares(Pressure pressure, double reach, double poisson) {
  Layers out{};
  const double all = sunk(pressure, reach, 0.0, poisson);
  double above = all;
  for (std::size_t k = 0; k < kLayers; ++k) {
    const double below = k + 1 < kLayers ? sunk(pressure, reach, layer_end(k + 1), poisson) : 0.0;
    out[k] = (above - below) / all;
    above = below;
  }
  return out;
}

double poisson_of(double mu, double bulk) { return (3.0 * bulk - 2.0 * mu) / (2.0 * (3.0 * bulk + mu)); }
double plane_modulus_of(double mu, double bulk) { return 2.0 * mu / (1.0 - poisson_of(mu, bulk)); }  // E / (1 - nu^2)

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

bool is_constant(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [&](double value) { return value == values.front(); });
}

/// Finds the tetrahedra at a point.
class Places {
 public:
  Places(const BodyData& data, double size) : data_(data), size_(size) {
    for (std::size_t t = 0; t < data.tets.size() / 4; ++t) {
      Vec3 low = corner(t, 0), high = low;
      for (std::size_t k = 1; k < 4; ++k) {
        low = low.cwiseMin(corner(t, k));
        high = high.cwiseMax(corner(t, k));
      }
      Eigen::Matrix3d edges;
      for (int k = 0; k < 3; ++k) edges.col(k) = corner(t, to_index(k + 1)) - corner(t, 0);
      inverse_.emplace_back(edges.inverse());
      const Cell from = cell(low), to = cell(high);
      for (int i = from[0]; i <= to[0]; ++i)
        for (int j = from[1]; j <= to[1]; ++j)
          for (int k = from[2]; k <= to[2]; ++k) cells_[{i, j, k}].push_back(t);
    }
  }
  /// Mean of the values of the tetrahedra at a point, of several ones on their common border; `otherwise` outside.
  [[nodiscard]] double mean_at(const Vec3& p, const std::vector<double>& values, double otherwise) const {
    const auto found = cells_.find(cell(p));
    double sum = 0.0, count = 0.0;
    if (found != cells_.end())
      for (const std::size_t t : found->second)
        if (contains(t, p)) {
          sum += values[t];
          count += 1.0;
        }
    return count > 0.0 ? sum / count : otherwise;
  }

 private:
  using Cell = std::array<int, 3>;
  [[nodiscard]] Vec3 corner(std::size_t t, std::size_t k) const {
    return Vec3(&data_.nodes[3 * to_index(data_.tets[4 * t + k])]);
  }
  [[nodiscard]] Cell cell(const Vec3& p) const {
    Cell c{};
    for (int k = 0; k < 3; ++k) c[to_index(k)] = static_cast<int>(std::floor(p[k] / size_));
    return c;
  }
  [[nodiscard]] bool contains(std::size_t t, const Vec3& p) const {
    constexpr double kBorder = -1e-6;
    const Vec3 b = inverse_[t] * (p - corner(t, 0));
    return b.minCoeff() >= kBorder && b.sum() <= 1.0 - kBorder;
  }

  const BodyData& data_;
  double size_;
  std::vector<Eigen::Matrix3d> inverse_;  // of the edges of each tetrahedron
  std::map<Cell, std::vector<std::size_t>> cells_;
};

/// Power mean of a value of the tetrahedra in each layer below the triangles around a vertex.
std::vector<Layers> layers_below(const scene::Mesh& mesh, const BodyData& data, const std::vector<double>& values,
                                 double edge, double width, double power) {
  constexpr double kCorners[4][3] = {{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0},
                                     {2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0},
                                     {1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0},
                                     {1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0}};
  const Places places(data, edge);
  const scene::Mesh::Impl& m = mesh.impl();
  std::vector<Layers> out(m.vertices.size() / 3, Layers{});
  std::vector<double> weight(out.size(), 0.0);
  for (std::int32_t c = 0; c < static_cast<std::int32_t>(m.triangles.size()); c += 3) {
    const Vec3 area = (m.corner(c + 1) - m.corner(c)).cross(m.corner(c + 2) - m.corner(c));
    for (const auto& b : kCorners) {
      const Vec3 p = m.position({c / 3, b[1], b[2]}), down = -area.normalized();
      double found = values.front();
      for (std::size_t k = 0; k < kLayers; ++k) {
        found = places.mean_at(p + 0.5 * width * (layer_end(k) + layer_end(k + 1)) * down, values, found);
        for (int n = 0; n < 3; ++n)
          out[to_index(m.triangles[to_index(c + n)])][k] += b[n] * area.norm() * std::pow(found, power);
      }
      for (int n = 0; n < 3; ++n) weight[to_index(m.triangles[to_index(c + n)])] += b[n] * area.norm();
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i)
    for (double& value : out[i]) value = std::pow(value / weight[i], 1.0 / power);
  return out;
}

/// Modulus that yields as layers do.
double felt(const Layers& shares, const Layers& modulus) {
  double yield = 0.0;
  for (std::size_t k = 0; k < kLayers; ++k) yield += shares[k] / modulus[k];
  return 1.0 / yield;
}

}  // namespace

DepthModuli::DepthModuli(const scene::Mesh& mesh, const BodyData& data, double edge, double width)
    : values_(mesh.vertices().size() / 3), width_(width) {
  std::vector<double> modulus;
  modulus.reserve(data.mu.size());
  for (std::size_t t = 0; t < data.mu.size(); ++t) modulus.push_back(plane_modulus_of(data.mu[t], data.bulk[t]));
  Values all{{}, modulus.front(), data.yeoh.front()};
  all.pressed.fill(modulus.front());
  std::fill(values_.begin(), values_.end(), all);
  const double poisson = poisson_of(mean(data.mu), mean(data.bulk));
  std::array<Layers, kContacts> under;
  for (std::size_t c = 0; c < kContacts; ++c) under[c] = shares(hertz, kNarrowest * std::exp2(c), poisson);
  if (!is_constant(modulus)) {
    const Layers spread = shares(gauss, kGaussReach, poisson);
    const std::vector<Layers> layers = layers_below(mesh, data, modulus, edge, width, kBeside);
    for (std::size_t i = 0; i < values_.size(); ++i) {
      for (std::size_t c = 0; c < kContacts; ++c) values_[i].pressed[c] = felt(under[c], layers[i]);
      values_[i].spread = felt(spread, layers[i]);
    }
  }
  if (!is_constant(data.yeoh)) {
    const std::vector<Layers> layers = layers_below(mesh, data, data.yeoh, edge, width, 1.0);
    for (std::size_t i = 0; i < values_.size(); ++i)
      values_[i].yeoh = std::inner_product(layers[i].begin(), layers[i].end(), under[kContacts / 2].begin(), 0.0);
  }
  constant_ = std::all_of(values_.begin(), values_.end(), [&](const Values& v) { return v == values_.front(); });
}

// A contact of the radius a = sqrt(R d) has the tangent 2 a E(a). With E linear in d, E = E0 + E1 x with x = d / R, the
// force is 4/3 E0 sqrt(R) d^1.5 (1 + 3/5 E1 / E0 x).
DepthModuli::Felt DepthModuli::at(std::span<const std::int32_t> vertex, const double* weight,
                                  double radius) const noexcept {
  Values mean{};
  for (std::size_t i = 0; i < vertex.size() && !constant_; ++i) {
    const Values& one = values_[to_index(vertex[i])];
    for (std::size_t c = 0; c < kContacts; ++c) mean.pressed[c] += weight[i] * one.pressed[c];
    mean.spread += weight[i] * one.spread;
    mean.yeoh += weight[i] * one.yeoh;
  }
  if (constant_) mean = values_.front();
  const auto modulus = [&](double depth) {  // [radius]
    const double place = std::log2(std::sqrt(depth) * radius / (kNarrowest * width_));
    const double most = static_cast<double>(kContacts) - 1.0, s = std::clamp(place, 0.0, most - 1e-9);
    const auto i = static_cast<std::size_t>(s);
    return mean.pressed[i] + (s - static_cast<double>(i)) * (mean.pressed[i + 1] - mean.pressed[i]);
  };
  const double low = modulus(kLow), slope = (modulus(kHigh) - low) / (kHigh - kLow);
  const double start = std::max(low - kLow * slope, 0.1 * low);
  const double wider = std::clamp(0.6 * slope / start, kLeastGrowth, kMostGrowth);
  const double stiffer = std::min(kYeoh * mean.yeoh, kMostGrowth);
  const double middle = low + (kMiddle - kLow) * slope;
  return {middle / (1.0 + wider / 0.6 * kMiddle), wider + stiffer, mean.spread};
}

}  // namespace palpate::tissue
