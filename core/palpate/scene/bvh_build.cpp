// Top-down build of the BVH. Large ranges are split by the binned surface-area heuristic. Small ranges are split at
// medians that are multiples of four, so that the blocks of the leaves are full. Two threads may share the work; the
// shape of the tree does not depend on it.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <system_error>
#include <thread>
#include <vector>

#include "palpate/scene/bvh.hpp"
#include "palpate/scene/bvh_disc.hpp"

namespace palpate::scene {
namespace {

constexpr std::size_t kLeaf = kTrianglesPerBlock;
constexpr std::size_t kWide = 8;              // children per node
constexpr std::size_t kSmall = 128;           // smaller ranges are split at multiples of kLeaf
constexpr std::size_t kMinSide = 8;           // smallest part of a binned split, which bounds the number of blocks
constexpr int kBins = 16;                     // bins of a binned split
constexpr int kBinnedDepth = 14;              // deeper nodes are split at medians, which bounds the depth of the tree
constexpr int kMedianDepth = 28;              // each median halves the blocks, and a mesh has fewer than 2^28 of them
constexpr std::size_t kDisc = 256;            // a range with more triangles is hardly flat and gets no disc
constexpr std::size_t kThreadedSize = 50000;  // a smaller mesh is built on one thread
constexpr float kInf = std::numeric_limits<float>::infinity();
static_assert(kBinnedDepth + kMedianDepth <= kBvhLevels);

/// Axis-aligned bounding box, initially empty.
struct Bounds {
  float lo[3] = {kInf, kInf, kInf};
  float hi[3] = {-kInf, -kInf, -kInf};

  void add(const float* l, const float* h) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], l[k]);
      hi[k] = std::max(hi[k], h[k]);
    }
  }
  void add(const Bounds& b) { add(b.lo, b.hi); }
  [[nodiscard]] float half_area() const {
    const float x = hi[0] - lo[0], y = hi[1] - lo[1], z = hi[2] - lo[2];
    return x * y + y * z + z * x;
  }
};

/// Bounding box and index of one triangle. Partitioning moves whole items, so that every pass reads memory in order.
struct Item {
  float lo[3];
  float hi[3];
  std::int32_t id;

  [[nodiscard]] float twice_centre(int axis) const { return lo[axis] + hi[axis]; }
};

/// A contiguous range of items and its bounds.
struct Range {
  std::size_t begin = 0;
  std::size_t end = 0;
  Bounds box;
  Bounds centres;  // bounds of the items' centres, times two

  [[nodiscard]] std::size_t size() const { return end - begin; }
};

class BvhBuilder {
 public:
  BvhBuilder(std::span<const double> vertices, std::span<const std::int32_t> triangles)
      : vertices_(vertices), triangles_(triangles), items_(triangles.size() / 3) {}

  Bvh build() {
    frame();
    Range all = items();
    // Each part of a binned split has at least kMinSide items, and the blocks of a small range are full except for one.
    // There are therefore fewer than n/4 + n/8 + 1 blocks. Every node has at least two children, so there are fewer
    // nodes than blocks. Unused pages of the arrays cost no memory.
    const std::size_t capacity = items_.size() / 2 + 64;
    bvh_.nodes.reset(new BvhNode[capacity]);  // not initialised: make_shared would touch every page
    bvh_.blocks.reset(new TriangleBlock[capacity]);
    bvh_.ids.reset(new std::int32_t[capacity * kLeaf]);
    root(all);
    bvh_.node_count = static_cast<std::size_t>(next_node_.load());
    bvh_.block_count = static_cast<std::size_t>(next_block_.load());
    return std::move(bvh_);
  }

 private:
  /// A node to fill from a range of items.
  struct Job {
    Range range;
    std::int32_t node = 0;
    int depth = 0;
  };

  /// Computes the centre and the power-of-two scale of the mesh's bounding box.
  void frame() {
    double lo[3], hi[3], half = 0.0;
    for (int k = 0; k < 3; ++k) lo[k] = hi[k] = vertices_[static_cast<std::size_t>(triangles_[0]) * 3 + k];
    for (std::size_t i = 0; i < vertices_.size(); i += 3) {
      for (int k = 0; k < 3; ++k) {
        lo[k] = std::min(lo[k], vertices_[i + k]);
        hi[k] = std::max(hi[k], vertices_[i + k]);
      }
    }
    for (int k = 0; k < 3; ++k) {
      bvh_.centre[k] = lo[k] + 0.5 * (hi[k] - lo[k]);
      half = std::max(half, 0.5 * (hi[k] - lo[k]));
    }
    if (half > 0.0) bvh_.scale = std::ldexp(1.0, -std::ilogb(half) - 1);
  }

  /// Fills the items. Returns the range of all items.
  Range items() {
    Range all;
    all.end = items_.size();
    for (std::size_t t = 0; t < items_.size(); ++t) {
      Item& item = items_[t];
      item.id = static_cast<std::int32_t>(t);
      for (int k = 0; k < 3; ++k) {
        double lo = std::numeric_limits<double>::infinity(), hi = -lo;
        for (std::size_t c = 0; c < 3; ++c) {
          const double x = vertices_[static_cast<std::size_t>(triangles_[3 * t + c]) * 3 + k];
          lo = std::min(lo, x);
          hi = std::max(hi, x);
        }
        // The margin of 2^-24 is twice the largest rounding error of a float in [-1, 1].
        item.lo[k] = static_cast<float>((lo - bvh_.centre[k]) * bvh_.scale) - 0x1p-24F;
        item.hi[k] = static_cast<float>((hi - bvh_.centre[k]) * bvh_.scale) + 0x1p-24F;
      }
      include(all, item);
    }
    return all;
  }

  static void include(Range& range, const Item& item) {
    range.box.add(item.lo, item.hi);
    const float c[3] = {item.twice_centre(0), item.twice_centre(1), item.twice_centre(2)};
    range.centres.add(c, c);
  }

  static int widest(const Bounds& box) {
    const float d[3] = {box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]};
    return d[0] >= d[1] ? (d[0] >= d[2] ? 0 : 2) : (d[1] >= d[2] ? 1 : 2);
  }

  Range bounded(std::size_t begin, std::size_t end) const {
    Range range;
    range.begin = begin;
    range.end = end;
    for (std::size_t i = begin; i < end; ++i) include(range, items_[i]);
    return range;
  }

  std::array<Range, 2> split(const Range& range, int depth) {
    if (range.size() > kSmall && depth < kBinnedDepth) {
      std::array<Range, 2> halves;
      if (split_binned(range, halves)) return halves;
    }
    return split_median(range);
  }

  bool split_binned(const Range& range, std::array<Range, 2>& halves) {
    const int axis = widest(range.centres);
    const float from = range.centres.lo[axis], width = range.centres.hi[axis] - from;
    if (!(width > 0.0F)) return false;
    const float to_bin = static_cast<float>(kBins) / width;
    const auto bin_of = [&](const Item& item) {
      return std::min(static_cast<int>((item.twice_centre(axis) - from) * to_bin), kBins - 1);
    };
    std::array<Bounds, kBins> box;
    std::array<std::size_t, kBins> count{};
    for (std::size_t i = range.begin; i < range.end; ++i) {
      const auto b = static_cast<std::size_t>(bin_of(items_[i]));
      box[b].add(items_[i].lo, items_[i].hi);
      ++count[b];
    }
    const int cut = best_cut(box, count, range.size());
    if (cut < 0) return false;

    const auto first = items_.begin();
    const auto middle =
        std::partition(first + static_cast<std::ptrdiff_t>(range.begin), first + static_cast<std::ptrdiff_t>(range.end),
                       [&](const Item& item) { return bin_of(item) < cut; });
    const auto m = static_cast<std::size_t>(middle - first);
    halves = {bounded(range.begin, m), bounded(m, range.end)};
    return true;
  }

  /// Bin at which a split has the smallest sum of area times count, with enough items on both sides. -1: no such bin.
  static int best_cut(const std::array<Bounds, kBins>& box, const std::array<std::size_t, kBins>& count,
                      std::size_t total) {
    std::array<float, kBins> cost_right{};
    Bounds right;
    std::size_t n = 0;
    for (std::size_t b = kBins - 1; b > 0; --b) {
      right.add(box[b]);
      n += count[b];
      cost_right[b] = n > 0 ? right.half_area() * static_cast<float>(n) : 0.0F;
    }
    Bounds left;
    n = 0;
    int best = -1;
    float best_cost = kInf;
    for (std::size_t b = 1; b < kBins; ++b) {
      left.add(box[b - 1]);
      n += count[b - 1];
      if (n < kMinSide || total - n < kMinSide) continue;
      const float cost = left.half_area() * static_cast<float>(n) + cost_right[b];
      if (cost < best_cost) {
        best_cost = cost;
        best = static_cast<int>(b);
      }
    }
    return best;
  }

  std::array<Range, 2> split_median(const Range& range) {
    const int axis = widest(range.centres);
    const std::size_t blocks = (range.size() + kLeaf - 1) / kLeaf;
    const std::size_t m = range.begin + blocks / 2 * kLeaf;
    const auto first = items_.begin();
    std::nth_element(first + static_cast<std::ptrdiff_t>(range.begin), first + static_cast<std::ptrdiff_t>(m),
                     first + static_cast<std::ptrdiff_t>(range.end), [axis](const Item& x, const Item& y) {
                       const float cx = x.twice_centre(axis), cy = y.twice_centre(axis);
                       return cx < cy || (cx == cy && x.id < y.id);
                     });
    return {bounded(range.begin, m), bounded(m, range.end)};
  }

  /// Splits the child with the largest area until there are eight children or only leaves. Returns the number of
  /// children.
  std::size_t open(const Range& range, int depth, std::array<Range, kWide>& children) {
    children[0] = range;
    std::size_t n = 1;
    while (n < kWide) {
      std::size_t pick = kWide;
      float largest = -1.0F;
      for (std::size_t i = 0; i < n; ++i) {
        if (children[i].size() > kLeaf && children[i].box.half_area() > largest) {
          pick = i;
          largest = children[i].box.half_area();
        }
      }
      if (pick == kWide) break;
      const std::array<Range, 2> halves = split(children[pick], depth);
      children[pick] = halves[0];
      children[n++] = halves[1];
    }
    return n;
  }

  /// Writes one triangle block. Returns its index.
  std::int32_t block(const Range& range) {
    const std::int32_t index = next_block_.fetch_add(1, std::memory_order_relaxed);
    TriangleBlock& block = bvh_.blocks[static_cast<std::size_t>(index)];
    for (std::size_t lane = 0; lane < kLeaf; ++lane) {
      const std::int32_t id = items_[std::min(range.begin + lane, range.end - 1)].id;
      const std::int32_t* t = &triangles_[static_cast<std::size_t>(id) * 3];
      for (std::size_t k = 0; k < 3; ++k) {
        const double a = vertices_[static_cast<std::size_t>(t[0]) * 3 + k];
        block.a[k][lane] = a;
        block.e1[k][lane] = vertices_[static_cast<std::size_t>(t[1]) * 3 + k] - a;
        block.e2[k][lane] = vertices_[static_cast<std::size_t>(t[2]) * 3 + k] - a;
      }
      bvh_.ids[static_cast<std::size_t>(index) * kLeaf + lane] = id;
    }
    return index;
  }

  Disc disc_of(const Range& range) const {
    if (range.size() > kDisc) return {};
    std::array<Corner, 3 * kDisc> corners;
    for (std::size_t i = 0; i < 3 * range.size(); ++i) {
      const auto t = static_cast<std::size_t>(items_[range.begin + i / 3].id);
      const double* x = &vertices_[static_cast<std::size_t>(triangles_[3 * t + i % 3]) * 3];
      for (std::size_t k = 0; k < 3; ++k) corners[i][k] = (x[k] - bvh_.centre[k]) * bvh_.scale;
    }
    return disc_around({corners.data(), 3 * range.size()});
  }

  /// Fills one node. Calls `pending` for each child that is not a leaf.
  template <class Pending>
  void fill(const Job& job, Pending&& pending) {
    std::array<Range, kWide> children;
    const std::size_t n = open(job.range, job.depth, children);
    BvhNode& node = bvh_.nodes[static_cast<std::size_t>(job.node)];
    for (std::size_t i = 0; i < kWide; ++i) {
      const Bounds box = i < n ? children[i].box : Bounds{};
      for (int k = 0; k < 3; ++k) {
        node.lo[k][i] = box.lo[k];
        node.hi[k][i] = box.hi[k];
      }
      const Disc disc = i < n ? disc_of(children[i]) : Disc{};
      for (std::size_t k = 0; k < 3; ++k) {
        node.centre[k][i] = disc.centre[k];
        node.normal[k][i] = disc.normal[k];
      }
      node.radius[i] = disc.radius;
      node.half[i] = disc.half;
      node.child[i] = 0;
      if (i >= n) continue;
      if (children[i].size() <= kLeaf) {
        node.child[i] = ~block(children[i]);
      } else {
        node.child[i] = next_node_.fetch_add(1, std::memory_order_relaxed);
        pending(Job{children[i], node.child[i], job.depth + 1});
      }
    }
  }

  void subtree(const Job& job) {
    fill(job, [this](const Job& next) { subtree(next); });
  }

  /// Builds the first two levels, then the subtrees below them on up to two threads.
  void root(const Range& all) {
    std::vector<Job> jobs, subtrees;
    fill(Job{all, next_node_.fetch_add(1), 0}, [&](const Job& job) { jobs.push_back(job); });
    for (const Job& job : jobs) fill(job, [&](const Job& next) { subtrees.push_back(next); });
    std::atomic<std::size_t> next{0};
    const auto work = [&] {
      for (std::size_t i = next.fetch_add(1); i < subtrees.size(); i = next.fetch_add(1)) subtree(subtrees[i]);
    };
    std::thread helper;
    if (items_.size() >= kThreadedSize) {
      try {
        helper = std::thread(work);
      } catch (const std::system_error&) {  // no second thread is available: this thread builds everything
      }
    }
    work();
    if (helper.joinable()) helper.join();
  }

  std::span<const double> vertices_;
  std::span<const std::int32_t> triangles_;
  std::vector<Item> items_;
  Bvh bvh_;
  std::atomic<std::int32_t> next_node_{0};
  std::atomic<std::int32_t> next_block_{0};
};

}  // namespace

Bvh build_bvh(std::span<const double> vertices, std::span<const std::int32_t> triangles) {
  return BvhBuilder(vertices, triangles).build();
}

}  // namespace palpate::scene
