#include "palpate/clouds/point_grid.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace palpate::clouds {
namespace {

constexpr double kMaxCells = 8e6;          // larger grids get larger cells
constexpr double kCell = 0.67;             // [reach] side of a cell
constexpr int kMinNeighbours = 5;          // points with fewer neighbours are flying pixels
constexpr double kGrazing = 0.12;          // cosine between normal and line of sight below which a point is not trusted
constexpr float kMaxWeight = 255.0F;       // largest weight of an averaged point
constexpr std::int64_t kOffset = 1 << 20;  // voxel indices are within +-2^20

/// Sum over the points of one voxel.
struct Voxel {
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

/// Numbers voxels in the order in which they are added. Open addressing with linear probing.
class VoxelNumbers {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  explicit VoxelNumbers(std::size_t most) {
    std::size_t slots = 1024;
    while (slots < 2 * most) slots *= 2;
    slots_.resize(slots);
  }
  /// Number of a voxel, which is new if it equals size().
  std::uint32_t add(std::uint64_t key) {
    Slot& slot = slots_[place(key)];
    if (slot.key == 0) slot = {key, size_++};
    return slot.number;
  }
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const noexcept {
    const Slot& slot = slots_[place(key)];
    return slot.key == key ? slot.number : kNone;
  }

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t number = 0;
  };
  [[nodiscard]] std::size_t place(std::uint64_t key) const noexcept {
    std::size_t slot = (key * 0x9E3779B97F4A7C15U) >> 20U & (slots_.size() - 1);
    while (slots_[slot].key != 0 && slots_[slot].key != key) slot = (slot + 1) & (slots_.size() - 1);
    return slot;
  }

  std::vector<Slot> slots_;
  std::uint32_t size_ = 0;
};

/// Means of the points in each voxel, in the order of their first points.
std::vector<Voxel> average(std::span<const double> points, std::span<const double> normals, double voxel) {
  const std::size_t n = points.size() / 3;
  VoxelNumbers numbers(n);
  std::vector<Voxel> found;
  found.reserve(n / 2 + 16);
  const double per_voxel = 1.0 / voxel;
  for (std::size_t i = 0; i < n; ++i) {
    const double* p = &points[3 * i];
    const std::uint32_t number = numbers.add(key_of(p, per_voxel));
    if (number == found.size()) found.push_back({});
    Voxel& v = found[number];
    v.p += Vec3(p);
    if (!normals.empty()) v.n += Vec3(&normals[3 * i]);
    v.count += 1.0F;
  }
  return found;
}

/// Number, sum and sum of squares of points.
struct Moments {
  int count = 0;
  Vec3 sum = Vec3::Zero(), squares = Vec3::Zero(), mixed = Vec3::Zero();  // of xx, yy, zz and of yz, zx, xy

  void add(const Vec3& p) noexcept {
    ++count;
    sum += p;
    squares += p.cwiseProduct(p);
    mixed += Vec3(p.y() * p.z(), p.z() * p.x(), p.x() * p.y());
  }
  void add(const Moments& m) noexcept {
    count += m.count;
    sum += m.sum;
    squares += m.squares;
    mixed += m.mixed;
  }
  /// Unit normal of the plane through the points, of either sign.
  [[nodiscard]] Vec3 normal() const {
    const Vec3 mean = sum / count;
    Mat3 spread;
    spread << squares.x(), mixed.z(), mixed.y(), mixed.z(), squares.y(), mixed.x(), mixed.y(), mixed.x(), squares.z();
    spread = spread / count - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Mat3> axes;
    axes.computeDirect(spread / std::max(spread.trace(), 1e-30));
    return axes.eigenvectors().col(0);
  }
};

/// Planes through the points of blocks of 3 x 3 x 3 cells. A block is twice as wide as `reach`.
class Planes {
 public:
  Planes(const std::vector<GridPoint>& points, double reach) : per_cell_(1.5 / reach), numbers_(points.size()) {
    std::vector<Moments> moments;
    std::vector<std::uint64_t> keys;
    for (const GridPoint& s : points) {
      const Vec3 p = position(s);
      const std::uint64_t key = key_of(p.data(), per_cell_);
      const std::uint32_t number = numbers_.add(key);
      if (number == moments.size()) {
        moments.push_back({});
        keys.push_back(key);
      }
      moments[number].add(p);
    }
    for (const std::uint64_t key : keys) {
      Moments block;
      for (std::uint64_t x = 0; x < 3; ++x)
        for (std::uint64_t y = 0; y < 3; ++y)
          for (std::uint64_t z = 0; z < 3; ++z) {
            const std::uint32_t number = numbers_.find(key + ((x - 1) << 42U) + ((y - 1) << 21U) + (z - 1));
            if (number != VoxelNumbers::kNone) block.add(moments[number]);
          }
      planes_.push_back({block.count, block.count > kMinNeighbours ? block.normal() : Vec3(Vec3::Zero())});
    }
  }

  struct Plane {
    int count;    ///< number of points in the block
    Vec3 normal;  ///< unit normal of either sign
  };
  /// The plane of the block around one of the points.
  [[nodiscard]] const Plane& at(const GridPoint& s) const noexcept {
    return planes_[numbers_.find(key_of(position(s).data(), per_cell_))];
  }

 private:
  static Vec3 position(const GridPoint& s) noexcept { return {s.p[0], s.p[1], s.p[2]}; }

  double per_cell_;
  VoxelNumbers numbers_;
  std::vector<Plane> planes_;
};

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
  estimate_normals(viewpoint, reach);
  sort(reach);
}

/// Sorts the points by cell (counting sort), with the cells of a row next to each other in x.
void PointGrid::sort(double reach) {
  Vec3 high = Vec3::Zero();
  for (const GridPoint& s : points_) high = high.cwiseMax(Vec3(s.p[0], s.p[1], s.p[2]));
  const Vec3 extent = high.array() + reach;
  const double edge = std::max(kCell * reach, std::cbrt(extent.prod() / kMaxCells));
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
  const Planes planes(points_, reach);
  const auto normal_at = [&](const GridPoint& s) -> Vec3 {  // zero: the point is not on a surface
    const Planes::Plane& plane = planes.at(s);
    if (plane.count <= kMinNeighbours) return Vec3::Zero();
    const Vec3 known(s.n[0], s.n[1], s.n[2]);
    if (!known.isZero(0.0) || !viewpoint) return known.isZero(0.0) ? plane.normal : known;
    const double cosine = plane.normal.dot((*viewpoint - origin_ - Vec3(s.p[0], s.p[1], s.p[2])).normalized());
    if (std::abs(cosine) < kGrazing) return Vec3::Zero();
    return cosine < 0.0 ? Vec3(-plane.normal) : plane.normal;
  };
  for (GridPoint& s : points_) {
    const Vec3 n = normal_at(s);
    if (!n.allFinite() || n.isZero(0.0)) s.weight = 0.0F;
    for (int k = 0; k < 3; ++k) s.n[k] = static_cast<float>(n[k]);
  }
  rejected_ = std::erase_if(points_, [](const GridPoint& s) { return s.weight == 0.0F; });
}

}  // namespace palpate::clouds
