#include "palpate/scene/topology.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/types/index.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {
namespace {

using Index = std::int32_t;

class TopologyBuilder {
 public:
  TopologyBuilder(std::span<const double> vertices, std::span<const Index> triangles)
      : vertices_(vertices), triangles_(triangles), count_(static_cast<Index>(triangles.size())) {}

  Topology build() {
    find_twins();
    smooth_normals();
    bound_height();
    for (Index t = 0; t < count_; t += 3) out_.flat_triangles += area(t).squaredNorm() > 0.0 ? 0 : 1;
    out_.twin = std::move(twin_);
    out_.normal = std::move(normal_);
    out_.normals = std::move(normals_);
    out_.smooth_vertex = std::move(smooth_vertex_);
    return std::move(out_);
  }

 private:
  [[nodiscard]] Vec3 vertex(Index v) const { return Vec3(&vertices_[3 * to_index(v)]); }
  [[nodiscard]] Vec3 normal(Index corner) const { return Vec3(&normals_[3 * to_index(normal_[to_index(corner)])]); }
  /// Vertices at the start and at the end of a half-edge.
  [[nodiscard]] Index from(Index he) const { return triangles_[to_index(he)]; }
  [[nodiscard]] Index to(Index he) const { return triangles_[to_index(next_half_edge(he))]; }
  [[nodiscard]] Vec3 area(Index he) const {  // normal of the triangle with the length of twice its area
    const Index t = he / 3 * 3;
    const Vec3 a = vertex(triangles_[to_index(t)]);
    return (vertex(triangles_[to_index(t + 1)]) - a).cross(vertex(triangles_[to_index(t + 2)]) - a);
  }

  /// Half-edges grouped by the vertex that they leave: those of vertex v are half_edge[first[v]] to
  /// half_edge[first[v + 1] - 1], in ascending order.
  struct Leaving {
    std::vector<Index> first, half_edge;
  };
  [[nodiscard]] Leaving group_by_start() const {
    Leaving leaving{std::vector<Index>(vertices_.size() / 3 + 1, 0), std::vector<Index>(to_index(count_))};
    std::vector<Index>& first = leaving.first;
    for (Index he = 0; he < count_; ++he) ++first[to_index(from(he)) + 1];
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    std::vector<Index> next(first.begin(), first.end() - 1);
    for (Index he = 0; he < count_; ++he) leaving.half_edge[to_index(next[to_index(from(he))]++)] = he;
    return leaving;
  }

  /// The half-edges a -> b: their number, the first and the last of them; -1 if there is none.
  struct Parallel {
    int count = 0;
    Index first = -1, last = -1;
  };
  [[nodiscard]] Parallel parallel(const Leaving& leaving, Index a, Index b) const {
    Parallel found;
    for (Index i = leaving.first[to_index(a)]; i < leaving.first[to_index(a) + 1]; ++i) {
      const Index he = leaving.half_edge[to_index(i)];
      if (to(he) != b) continue;
      if (found.count++ == 0) found.first = he;
      found.last = he;
    }
    return found;
  }

  /// Pairs each half-edge a -> b with the half-edge b -> a, which is found among those that leave b.
  void find_twins() {
    const Leaving leaving = group_by_start();
    twin_.assign(to_index(count_), -1);
    for (Index he = 0; he < count_; ++he) {
      if (twin_[to_index(he)] >= 0) continue;
      const Parallel along = parallel(leaving, from(he), to(he)), against = parallel(leaving, to(he), from(he));
      if (along.count == 1 && against.count == 1) {
        twin_[to_index(he)] = against.first;
        twin_[to_index(against.first)] = he;
      } else {
        report_unpaired(he, along, against);
      }
    }
    out_.closed = out_.rims.empty() && out_.inconsistent_pairs.empty() && out_.branching_edges == 0;
  }

  /// Reports an edge that does not join two triangles of equal winding, once: at the first half-edge between its two
  /// vertices.
  void report_unpaired(Index he, const Parallel& along, const Parallel& against) {
    if (along.count + against.count == 1) out_.rims.push_back(he);
    if (along.first != he || (against.count > 0 && against.first < he)) return;
    if (along.count == 2 && against.count == 0) out_.inconsistent_pairs.push_back({he, along.last});
    if (along.count + against.count > 2) ++out_.branching_edges;
  }

  /// True if the edge of `he` is not a crease.
  [[nodiscard]] bool smooth_across(Index he) const {
    const Index twin = twin_[to_index(he)];
    if (twin < 0) return false;
    static const double cos_crease = std::cos(kCreaseAngle);
    const Vec3 n = area(he), m = area(twin);
    return n.dot(m) > cos_crease * std::sqrt(n.squaredNorm() * m.squaredNorm());
  }

  /// Contribution of a corner to the normal of its vertex (Max 1999): exact if the vertices lie on a sphere.
  [[nodiscard]] Vec3 corner_contribution(Index he) const {
    const Vec3 v = vertex(from(he));
    const Vec3 e1 = vertex(to(he)) - v, e2 = vertex(from(previous_half_edge(he))) - v;
    const double weight = e1.squaredNorm() * e2.squaredNorm();
    return weight > 0.0 ? Vec3(e1.cross(e2) / weight) : Vec3::Zero();
  }

  /// Computes one normal for each fan of triangles around a vertex, between creases.
  void smooth_normals() {
    std::vector<bool> smooth(to_index(count_));
    for (Index he = 0; he < count_; ++he) {
      const Index twin = twin_[to_index(he)];
      smooth[to_index(he)] = twin >= 0 && twin < he ? smooth[to_index(twin)] : smooth_across(he);
    }
    normal_.assign(to_index(count_), -1);
    normals_.reserve(vertices_.size());
    for (Index start = 0; start < count_; ++start) {
      if (normal_[to_index(start)] >= 0) continue;
      const auto row = static_cast<Index>(normals_.size() / 3);
      Vec3 sum = Vec3::Zero();
      const auto take = [&](Index corner) {
        normal_[to_index(corner)] = row;
        sum += corner_contribution(corner);
      };
      take(start);
      bool around = false;
      for (Index he = start; smooth[to_index(previous_half_edge(he))];) {  // counter-clockwise around the vertex
        he = twin_[to_index(previous_half_edge(he))];
        if (he == start || normal_[to_index(he)] >= 0) {
          around = true;
          break;
        }
        take(he);
      }
      for (Index he = start;
           !around && smooth[to_index(he)];) {  // then clockwise, if a crease or boundary ended the first loop
        he = next_half_edge(twin_[to_index(he)]);
        if (normal_[to_index(he)] >= 0) break;
        take(he);
      }
      if (!(sum.squaredNorm() > 0.0)) sum = area(start);
      const double length = sum.norm();
      const Vec3 n = length > 0.0 ? Vec3(sum / length) : Vec3::Zero();
      normals_.insert(normals_.end(), n.data(), n.data() + 3);
      smooth_vertex_.push_back(around);
    }
  }

  /// Computes the bound on the height of the smooth surface over the triangles.
  void bound_height() {
    for (Index he = 0; he < count_; ++he) {
      const Vec3 e = vertex(to(he)) - vertex(from(he)), n = normal(he), m = normal(next_half_edge(he));
      out_.height = std::max(out_.height, std::abs(e.dot(m - n)) / 4.0 + std::abs(e.dot(m + n)) / 8.0);
    }
  }

  std::span<const double> vertices_;
  std::span<const Index> triangles_;
  Index count_;
  std::vector<Index> twin_, normal_;  // of the topology in the making
  std::vector<double> normals_;
  std::vector<std::uint8_t> smooth_vertex_;
  Topology out_;
};

}  // namespace

Topology build_topology(std::span<const double> vertices, std::span<const std::int32_t> triangles) {
  return TopologyBuilder(vertices, triangles).build();
}

}  // namespace palpate::scene
