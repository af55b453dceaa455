#include "palpate/scene/weld.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace palpate::scene {
namespace {

constexpr std::int32_t kEmpty = -1;

std::uint64_t mix(std::uint64_t h) {
  h ^= h >> 32;
  h *= 0x9E3779B97F4A7C15ULL;
  return h ^ (h >> 29);
}

/// Hash set of row numbers with open addressing. It grows by doubling.
class RowTable {
 public:
  explicit RowTable(std::size_t expected) : slots_(std::bit_ceil(expected * 2 + 16), kEmpty) {}

  /// Returns the stored row that equals the candidate; if there is none, stores and returns `row`. hash_of(row) is
  /// needed to grow.
  template <class Equal, class HashOf>
  std::int32_t find_or_add(std::uint64_t hash, std::int32_t row, Equal&& equal, HashOf&& hash_of) {
    if (2 * (size_ + 1) > slots_.size()) grow(hash_of);
    std::size_t i = hash & (slots_.size() - 1);
    while (slots_[i] != kEmpty) {
      if (equal(slots_[i])) return slots_[i];
      i = (i + 1) & (slots_.size() - 1);
    }
    slots_[i] = row;
    ++size_;
    return row;
  }

 private:
  template <class HashOf>
  void grow(HashOf&& hash_of) {
    std::vector<std::int32_t> old = std::exchange(slots_, std::vector<std::int32_t>(slots_.size() * 2, kEmpty));
    for (const std::int32_t row : old) {
      if (row == kEmpty) continue;
      std::size_t i = hash_of(row) & (slots_.size() - 1);
      while (slots_[i] != kEmpty) i = (i + 1) & (slots_.size() - 1);
      slots_[i] = row;
    }
  }

  std::vector<std::int32_t> slots_;
  std::size_t size_ = 0;
};

std::uint64_t hash_of_point(const double* x) {
  std::uint64_t h = mix(std::bit_cast<std::uint64_t>(x[0]));
  h = mix(h ^ std::bit_cast<std::uint64_t>(x[1]));
  return mix(h ^ std::bit_cast<std::uint64_t>(x[2]));
}

[[noreturn]] void not_finite(std::size_t vertex) {
  throw std::invalid_argument("mesh: vertex " + std::to_string(vertex) +
                              " is not finite (NaN or infinity); repair or re-export the mesh");
}

/// Maps input vertices to welded vertices, which it appends to `out`.
class VertexWelder {
 public:
  VertexWelder(std::span<const double> vertices, std::size_t corners, std::vector<double>& out)
      : vertices_(vertices), out_(out), table_(std::min(vertices.size() / 3, corners) / 4) {
    // In an indexed mesh the triangles share vertices, and known_ avoids hashing a vertex twice. In a triangle soup
    // this table would not help.
    soup_ = vertices.size() / 3 >= corners;
    if (!soup_) known_.assign(vertices.size() / 3, kEmpty);
  }

  std::int32_t operator()(std::int32_t vertex) {
    const auto v = static_cast<std::size_t>(vertex);
    if (!soup_ && known_[v] != kEmpty) return known_[v];
    double x[3];
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = vertices_[3 * v + k] + 0.0;  // -0 becomes 0
      if (!std::isfinite(x[k])) not_finite(v);
    }
    const auto next = static_cast<std::int32_t>(out_.size() / 3);
    const std::int32_t row = table_.find_or_add(
        hash_of_point(x), next,
        [&](std::int32_t r) {
          const double* y = &out_[3 * static_cast<std::size_t>(r)];
          return y[0] == x[0] && y[1] == x[1] && y[2] == x[2];
        },
        [&](std::int32_t r) { return hash_of_point(&out_[3 * static_cast<std::size_t>(r)]); });
    if (row == next) out_.insert(out_.end(), x, x + 3);
    if (!soup_) known_[v] = row;
    return row;
  }

 private:
  std::span<const double> vertices_;
  std::vector<double>& out_;
  RowTable table_;
  bool soup_ = false;
  std::vector<std::int32_t> known_;
};

struct Corners {
  std::int32_t a, b, c;
};

/// Corners of a triangle in cyclic order, starting with the smallest index.
Corners canonical(const std::int32_t* t) {
  if (t[0] < t[1] && t[0] < t[2]) return {t[0], t[1], t[2]};
  return t[1] < t[2] ? Corners{t[1], t[2], t[0]} : Corners{t[2], t[0], t[1]};
}

std::uint64_t hash_of_triangle(const Corners& t) {
  const auto word = [](std::int32_t i) { return static_cast<std::uint64_t>(i); };
  return mix(mix(word(t.a) << 32 | word(t.b)) ^ word(t.c));
}

}  // namespace

Welded weld(std::span<const double> vertices, std::span<const std::int32_t> triangles) {
  if (vertices.size() % 3 != 0 || triangles.size() % 3 != 0)
    throw std::invalid_argument("mesh: vertices and triangles come in rows of three");
  const std::size_t n = vertices.size() / 3, m = triangles.size() / 3;
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max() / 4);
  if (n > kMost * 3 || m > kMost) throw std::invalid_argument("mesh: more than 536 million triangles");
  if (m == 0) throw std::invalid_argument("mesh: no triangles; load a surface mesh (a point cloud has none)");

  Welded out;
  out.vertices.reserve(std::min(n, m / 2 + m / 32 + 64) * 3);  // a closed surface has about m/2 vertices
  out.triangles.reserve(3 * m);
  VertexWelder weld_vertex(vertices, 3 * m, out.vertices);
  RowTable seen(m);
  const auto corners_of = [&](std::int32_t row) {
    return canonical(&out.triangles[3 * static_cast<std::size_t>(row)]);
  };
  for (std::size_t t = 0; t < m; ++t) {
    std::int32_t corner[3];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int32_t v = triangles[3 * t + c];
      if (v < 0 || static_cast<std::size_t>(v) >= n)
        throw std::invalid_argument("mesh: triangle " + std::to_string(t) + " names vertex " + std::to_string(v) +
                                    ", but there are vertices 0 to " + std::to_string(n) + " - 1");
      corner[c] = weld_vertex(v);
    }
    if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) {
      ++out.degenerate;
      continue;
    }
    const auto next = static_cast<std::int32_t>(out.triangles.size() / 3);
    const Corners key = canonical(corner);
    const std::int32_t row = seen.find_or_add(
        hash_of_triangle(key), next,
        [&](std::int32_t r) {
          const Corners k = corners_of(r);
          return k.a == key.a && k.b == key.b && k.c == key.c;
        },
        [&](std::int32_t r) { return hash_of_triangle(corners_of(r)); });
    if (row != next) {
      ++out.duplicate;
      continue;
    }
    out.triangles.insert(out.triangles.end(), corner, corner + 3);
  }
  if (out.triangles.empty())
    throw std::invalid_argument("mesh: all " + std::to_string(m) +
                                " triangles are degenerate (two corners at one place); check the unit and the export");
  return out;
}

}  // namespace palpate::scene
