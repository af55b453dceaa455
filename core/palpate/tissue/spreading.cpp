#include "palpate/tissue/spreading.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kReach = 2.8;    // [width] radius of the Gaussian
constexpr double kCore = 0.246;   // [edge] regularises the action of forces on neighbouring vertices
constexpr double kMore = 0.0155;  // [1 / edge] yield that the regularised sum misses
constexpr int kDivisions = 4;     // of an edge: 16 small triangles, one point in the middle of each

/// Point of the quadrature with its share of area by corner.
struct Point {
  Vec3 p;
  double area;
  double b[3];
};

/// Barycentric weights of the centres of the small triangles.
std::vector<std::array<double, 3>> small_triangles() {
  std::vector<std::array<double, 3>> out;
  const double step = 1.0 / kDivisions;
  for (int i = 0; i < kDivisions; ++i)
    for (int j = 0; i + j < kDivisions; ++j) {
      const double v = (i + 1.0 / 3.0) * step, w = (j + 1.0 / 3.0) * step;
      out.push_back({1.0 - v - w, v, w});
      if (i + j + 1 >= kDivisions) continue;
      const double v2 = (i + 2.0 / 3.0) * step, w2 = (j + 2.0 / 3.0) * step;
      out.push_back({1.0 - v2 - w2, v2, w2});
    }
  return out;
}

/// Triangles sorted into cubes of the size of the reach.
class Grid {
 public:
  using Cell = std::array<int, 3>;
  explicit Grid(double size) : size_(size) {}
  void add(const Vec3& p, std::int32_t item) { cells_[cell(p)].push_back(item); }
  template <class Act>
  void near(const Vec3& p, Act&& act) const {
    const Cell at = cell(p);
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k)
          if (const auto found = cells_.find({at[0] + i, at[1] + j, at[2] + k}); found != cells_.end())
            for (const std::int32_t item : found->second) act(item);
  }

 private:
  [[nodiscard]] Cell cell(const Vec3& p) const {
    Cell c{};
    for (int k = 0; k < 3; ++k) c[to_index(k)] = static_cast<int>(std::floor(p[k] / size_));
    return c;
  }
  double size_;
  std::map<Cell, std::vector<std::int32_t>> cells_;
};

}  // namespace

Spreading::Spreading(std::span<const double> vertices, std::span<const std::int32_t> triangles, double width)
    : width_(width) {
  const auto vertex = [&](std::int32_t i) { return Vec3(&vertices[3 * to_index(i)]); };
  const std::size_t m = triangles.size() / 3;
  std::vector<Vec3> area(m, Vec3::Zero()), normal(vertices.size() / 3, Vec3::Zero());
  const std::vector<std::array<double, 3>> parts = small_triangles();
  double longest = 0.0;
  for (std::size_t t = 0; t < m; ++t) {
    const Vec3 a = vertex(triangles[3 * t]), b = vertex(triangles[3 * t + 1]), c = vertex(triangles[3 * t + 2]);
    area[t] = 0.5 * (b - a).cross(c - a);
    longest = std::max({longest, (b - a).norm(), (c - b).norm(), (a - c).norm()});
    for (std::size_t k = 0; k < 3; ++k) normal[to_index(triangles[3 * t + k])] += area[t];
  }
  const double reach = kReach * width;
  Grid grid(reach + longest);
  for (std::size_t t = 0; t < m; ++t) grid.add(vertex(triangles[3 * t]), static_cast<std::int32_t>(t));
  first_.push_back(0);
  std::vector<double> weight(normal.size(), 0.0);
  std::vector<std::int32_t> touched;
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const Vec3 x = vertex(static_cast<std::int32_t>(i));
    double sum = 0.0;
    grid.near(x, [&](std::int32_t item) {
      const std::size_t t = to_index(item);
      if (!(area[t].dot(normal[i]) > 0.0)) return;
      const double share = area[t].norm() / static_cast<double>(parts.size());
      for (const auto& b : parts) {
        const Vec3 p =
            b[0] * vertex(triangles[3 * t]) + b[1] * vertex(triangles[3 * t + 1]) + b[2] * vertex(triangles[3 * t + 2]);
        const double far2 = (p - x).squaredNorm();
        if (far2 > reach * reach) continue;
        const double value = share * std::exp(-0.5 * far2 / (width * width));
        sum += value;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::int32_t corner = triangles[3 * t + k];
          if (weight[to_index(corner)] == 0.0) touched.push_back(corner);
          weight[to_index(corner)] += b[k] * value;
        }
      }
    });
    if (!(sum > 0.0)) {  // a needle or a fold: the vertex alone
      touched.assign(1, static_cast<std::int32_t>(i));
      weight[i] = sum = 1.0;
    }
    std::sort(touched.begin(), touched.end());
    for (const std::int32_t j : touched) {
      entries_.push_back({j, weight[to_index(j)] / sum});
      weight[to_index(j)] = 0.0;
    }
    touched.clear();
    first_.push_back(entries_.size());
  }
  find_yields(vertices, triangles);
}

// A Gaussian of the standard deviation w yields 1 / (2 sqrt(pi) w) under its own mean (Boussinesq).
double Spreading::widened(double yield, double edge, double wider) noexcept {
  const double more = kMore / edge, smooth = std::max(yield - more, 0.0);
  return smooth / std::hypot(1.0, 2.0 * std::sqrt(std::numbers::pi) * wider * smooth) + more;
}

void Spreading::find_yields(std::span<const double> vertices, std::span<const std::int32_t> triangles) {
  const auto vertex = [&](std::int32_t i) { return Vec3(&vertices[3 * to_index(i)]); };
  std::vector<double> edge(first_.size() - 1, 0.0), edges(edge);  // mean length of the edges at each vertex
  for (std::size_t c = 0; c < triangles.size(); ++c) {
    const std::int32_t from = triangles[c], to = triangles[c % 3 == 2 ? c - 2 : c + 1];
    for (const std::int32_t i : {from, to}) {
      edge[to_index(i)] += (vertex(to) - vertex(from)).norm();
      edges[to_index(i)] += 1.0;
    }
  }
  for (std::size_t i = 0; i < edge.size(); ++i) edge[i] /= std::max(edges[i], 1.0);
  const auto between = [&](std::int32_t i, std::int32_t j) {
    double sum = kMore / std::sqrt(edge[to_index(i)] * edge[to_index(j)]);
    for (const Entry& a : row(i))
      for (const Entry& b : row(j)) {
        const double core2 = kCore * kCore * edge[to_index(a.vertex)] * edge[to_index(b.vertex)];
        const double far2 = (vertex(a.vertex) - vertex(b.vertex)).squaredNorm();
        sum += a.weight * b.weight / (std::numbers::pi * std::sqrt(far2 + core2));
      }
    return sum;
  };
  std::vector<double> self(edge.size());
  for (std::size_t i = 0; i < self.size(); ++i)
    self[i] = between(static_cast<std::int32_t>(i), static_cast<std::int32_t>(i));
  std::map<std::pair<std::int32_t, std::int32_t>, double> pairs;
  for (std::size_t c = 0; c < triangles.size(); c += 3) {
    for (std::size_t k = 0; k < 3; ++k) yield_.push_back(self[to_index(triangles[c + k])]);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto ends = std::minmax(triangles[c + k], triangles[c + (k + 1) % 3]);
      const std::pair<std::int32_t, std::int32_t> key{ends.first, ends.second};
      const auto [at, fresh] = pairs.try_emplace(key, 0.0);
      if (fresh) at->second = between(key.first, key.second);
      yield_.push_back(at->second);
    }
  }
}

}  // namespace palpate::tissue
