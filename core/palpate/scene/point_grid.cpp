#include "palpate/scene/point_grid.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace palpate::scene {
namespace {

constexpr double kMaxCells = 8e6;          // larger grids get larger cells
constexpr int kMinNeighbours = 5;          // points with fewer neighbours are flying pixels
constexpr double kGrazing = 0.12;          // cosine between normal and line of sight below which a point is not trusted
constexpr float kMaxWeight = 255.0F;       // largest weight of an averaged point
constexpr std::int64_t kOffset = 1 << 20;  // voxel indices are within +-2^20

/// Sum over the points of one voxel.
struct Voxel {
  std::uint64_t key = 0;  // 0: empty slot of the hash table
  Vec3 p = Vec3::Zero(), n = Vec3::Zero();
  float count = 0.0F;
};

std::uint64_t key_of(const double* p, double per_voxel) noexcept {
  std::uint64_t key = 1;  // never 0
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::int64_t>(std::floor(p[k] * per_voxel)) + kOffset;
    key = key << 21U | (static_cast<std::uint64_t>(i) & 0x1FFFFFU);
  }
  return key;
}

/// Means of the points in each voxel, in the order of their first points. Open addressing with linear probing.
std::vector<Voxel> average(std::span<const double> points, std::span<const double> normals, double voxel) {
  const std::size_t n = points.size() / 3;
  std::size_t slots = 1024;
  while (slots < 2 * n) slots *= 2;
  std::vector<std::uint32_t> table(slots, 0);  // index of the voxel plus one
  std::vector<Voxel> found;
  found.reserve(n / 2 + 16);
  const double per_voxel = 1.0 / voxel;
  for (std::size_t i = 0; i < n; ++i) {
    const double* p = &points[3 * i];
    const std::uint64_t key = key_of(p, per_voxel);
    std::size_t slot = (key * 0x9E3779B97F4A7C15U) >> 20U & (slots - 1);
    while (table[slot] != 0 && found[table[slot] - 1].key != key) slot = (slot + 1) & (slots - 1);
    if (table[slot] == 0) {
      found.push_back({});
      found.back().key = key;
      table[slot] = static_cast<std::uint32_t>(found.size());
    }
    Voxel& v = found[table[slot] - 1];
    v.p += Vec3(p);
    if (!normals.empty()) v.n += Vec3(&normals[3 * i]);
    v.count += 1.0F;
  }
  return found;
}

}  // namespace

PointGrid::PointGrid(std::span<const double> points, std::span<const double> normals,
                     const std::optional<Vec3>& viewpoint, double voxel, double reach) {
  const std::vector<Voxel> voxels = average(points, normals, voxel);
  Vec3 low = Vec3::Constant(1e300);
  for (const Voxel& v : voxels) low = low.cwiseMin(v.p / v.count);
  origin_ = voxels.empty() ? Vec3(Vec3::Zero()) : low;
  points_.reserve(voxels.size());
  for (const Voxel& v : voxels) {
    const Vec3 p = v.p / v.count - origin_;
    const double length = v.n.norm();
    const Vec3 n = length > 0.0 ? Vec3(v.n / length) : Vec3(Vec3::Zero());
    GridPoint out{};
    for (int k = 0; k < 3; ++k) {
      out.p[k] = static_cast<float>(p[k]);
      out.n[k] = static_cast<float>(n[k]);
    }
    out.weight = std::min(v.count, kMaxWeight);
    points_.push_back(out);
  }
  sort(reach);
  estimate_normals(viewpoint, reach);
}

/// Sorts the points by cell (counting sort), with the cells of a row next to each other in x.
void PointGrid::sort(double reach) {
  Vec3 high = Vec3::Zero();
  for (const GridPoint& s : points_) high = high.cwiseMax(Vec3(s.p[0], s.p[1], s.p[2]));
  const Vec3 extent = high.array() + reach;
  const double edge = std::max(reach, std::cbrt(extent.prod() / kMaxCells));
  per_cell_ = 1.0 / edge;
  for (int k = 0; k < 3; ++k) size_[k] = static_cast<std::size_t>(high[k] * per_cell_) + 1;
  const auto cell_of = [this](const GridPoint& s) {
    return (static_cast<std::size_t>(cell(s.p[2], 2)) * size_[1] + static_cast<std::size_t>(cell(s.p[1], 1))) *
               size_[0] +
           static_cast<std::size_t>(cell(s.p[0], 0));
  };
  start_.assign(size_[0] * size_[1] * size_[2] + 1, 0);
  for (const GridPoint& s : points_) ++start_[cell_of(s) + 1];
  for (std::size_t i = 1; i < start_.size(); ++i) start_[i] += start_[i - 1];
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  std::vector<GridPoint> sorted(points_.size());
  for (const GridPoint& s : points_) sorted[next[cell_of(s)]++] = s;
  points_ = std::move(sorted);
}

/// Normals of the planes through the neighbours, for points that have none; removes points that are not on a surface.
void PointGrid::estimate_normals(const std::optional<Vec3>& viewpoint, double reach) {
  std::vector<char> keep(points_.size(), 1);
  std::vector<GridPoint> with_normals = points_;
  const auto reach2 = static_cast<float>(reach * reach);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const GridPoint& s = points_[i];
    const bool known = s.n[0] != 0.0F || s.n[1] != 0.0F || s.n[2] != 0.0F;
    int count = 0;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    Eigen::Matrix3f squares = Eigen::Matrix3f::Zero();
    const Eigen::Map<const Eigen::Vector3f> at(s.p);
    visit_near(at.cast<double>(), reach, [&](const GridPoint& other, std::uint32_t) {
      const Eigen::Vector3f d = Eigen::Map<const Eigen::Vector3f>(other.p) - at;
      if (d.squaredNorm() > reach2) return;
      ++count;
      sum += d;
      squares.noalias() += d * d.transpose();
    });
    if (count <= kMinNeighbours) {
      keep[i] = 0;
      continue;
    }
    if (known) continue;
    const auto c = static_cast<float>(count);
    const Eigen::Matrix3f spread = squares / c - (sum / c) * (sum / c).transpose();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> axes;
    axes.computeDirect(spread / std::max(spread.trace(), 1e-30F));
    Eigen::Vector3f n = axes.eigenvectors().col(0);
    if (viewpoint) {
      const Eigen::Vector3f sight = (*viewpoint - origin_ - at.cast<double>()).normalized().cast<float>();
      const float cosine = n.dot(sight);
      if (cosine < 0.0F) n = -n;
      if (std::abs(cosine) < static_cast<float>(kGrazing)) keep[i] = 0;
    }
    if (!n.allFinite()) keep[i] = 0;
    Eigen::Map<Eigen::Vector3f>(with_normals[i].n) = n;
  }
  points_ = std::move(with_normals);
  const auto kept = static_cast<std::size_t>(std::count(keep.begin(), keep.end(), char{1}));
  rejected_ = points_.size() - kept;
  if (rejected_ == 0) return;
  std::size_t i = 0;
  points_.erase(std::remove_if(points_.begin(), points_.end(), [&](const GridPoint&) { return keep[i++] == 0; }),
                points_.end());
  sort(reach);
}

}  // namespace palpate::scene
