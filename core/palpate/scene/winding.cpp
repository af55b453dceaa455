#include "palpate/scene/winding.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/types/index.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {
namespace {

using Index = std::int32_t;

constexpr std::size_t kMostPairs = 1'000'000'000;  // bound on pairs of components compared to find cavities

/// Disjoint sets with parity: each member knows whether it is flipped relative to its root.
class Sets {
 public:
  explicit Sets(std::size_t n) : parent_(n), odd_(n, 0) {
    for (std::size_t i = 0; i < n; ++i) parent_[i] = static_cast<Index>(i);
  }

  /// Root of a member, and whether the member is flipped relative to it.
  struct Place {
    Index root;
    bool odd;
  };
  Place find(Index i) {
    bool odd = false;
    while (parent_[to_index(i)] != i) {
      const Index up = parent_[to_index(i)];
      odd_[to_index(i)] ^= odd_[to_index(up)];  // path halving; the parity of the root is always 0
      odd ^= odd_[to_index(i)] != 0;
      parent_[to_index(i)] = parent_[to_index(up)];
      i = parent_[to_index(i)];
    }
    return {i, odd};
  }
  /// Joins the sets of a and b. Returns false if they are already joined with the other parity.
  bool join(Index a, Index b, bool odd) {
    const Place x = find(a), y = find(b);
    if (x.root == y.root) return (x.odd ^ y.odd) == odd;
    const auto [low, high] = std::minmax(x.root, y.root);
    parent_[to_index(high)] = low;
    odd_[to_index(high)] = static_cast<std::uint8_t>(x.odd ^ y.odd ^ odd);
    return true;
  }

 private:
  std::vector<Index> parent_;
  std::vector<std::uint8_t> odd_;
};

/// Finds the triangles to flip.
struct OrientationCheck {
  std::span<const double> vertices;
  std::span<const Index> triangles;
  const Topology& topology;
  Winding out;
  Index count = static_cast<Index>(triangles.size() / 3);

  [[nodiscard]] Vec3 corner(Index he) const { return Vec3(&vertices[3 * to_index(triangles[to_index(he)])]); }

  /// Makes neighbours agree: flips the smaller group of triangles in each connected patch.
  void make_consistent() {
    Sets patches(to_index(count));
    for (Index he = 0; he < 3 * count; ++he)
      if (topology.twin[to_index(he)] > he) patches.join(he / 3, topology.twin[to_index(he)] / 3, false);
    std::vector<Index> one_sided;
    for (const auto& [a, b] : topology.inconsistent_pairs)
      if (!patches.join(a / 3, b / 3, true)) one_sided.push_back(a / 3);
    std::vector<Index> votes(to_index(count), 0);  // by root: triangles to keep minus triangles to flip
    for (Index t = 0; t < count; ++t) {
      const Sets::Place place = patches.find(t);
      votes[to_index(place.root)] += place.odd ? -1 : 1;
    }
    std::vector<bool> unorientable(to_index(count), false);
    for (const Index t : one_sided) unorientable[to_index(patches.find(t).root)] = true;
    out.two_sided = one_sided.empty();
    out.flip.assign(to_index(count), false);
    for (Index t = 0; t < count; ++t) {
      const Sets::Place place = patches.find(t);
      if (unorientable[to_index(place.root)] || place.odd != (votes[to_index(place.root)] >= 0)) continue;
      out.flip[to_index(t)] = true;
      ++out.flipped;
    }
    if (out.flipped == 0) out.flip.clear();
  }

  /// A component of the mesh.
  struct Component {
    double volume = 0.0;
    bool closed = true;
    Index triangles = 0;
    Vec3 low = Vec3::Constant(INFINITY), high = Vec3::Constant(-INFINITY);

    /// True if this component is closed and its bounding box contains that of p.
    [[nodiscard]] bool around(const Component& p) const {
      return closed && (low.array() <= p.low.array()).all() && (high.array() >= p.high.array()).all();
    }
  };

  /// Flips closed components that are inside out.
  void orient_outwards() {
    const std::size_t n = vertices.size() / 3;
    Sets by_vertex(n);
    for (Index he = 0; he < 3 * count; he += 3) {
      by_vertex.join(triangles[to_index(he)], triangles[to_index(he + 1)], false);
      by_vertex.join(triangles[to_index(he)], triangles[to_index(he + 2)], false);
    }
    std::vector<Index> component_of(n, -1);  // index of the component, by root
    std::vector<Component> components;
    const auto component_at = [&](Index he) -> Index {
      Index& p = component_of[to_index(by_vertex.find(triangles[to_index(he)]).root)];
      if (p < 0) {
        p = static_cast<Index>(components.size());
        components.emplace_back();
      }
      return p;
    };
    const Vec3 origin = corner(0);
    for (Index he = 0; he < 3 * count; he += 3) {
      Component& p = components[to_index(component_at(he))];
      const Vec3 a = corner(he), b = corner(he + 1), c = corner(he + 2);
      p.volume += (a - origin).dot((b - a).cross(c - a)) / 6.0;
      p.low = p.low.cwiseMin(a).cwiseMin(b).cwiseMin(c);
      p.high = p.high.cwiseMax(a).cwiseMax(b).cwiseMax(c);
      ++p.triangles;
    }
    for (const Index he : topology.rims) components[to_index(component_at(he))].closed = false;
    for (const auto& [a, b] : topology.inconsistent_pairs) components[to_index(component_at(a))].closed = false;

    std::vector<bool> inside_out(components.size(), false);
    std::size_t pairs_left = kMostPairs;
    for (std::size_t i = 0; i < components.size(); ++i) {
      if (!components[i].closed) continue;
      if (components[i].volume < 0.0) {
        const auto around = [&](const Component& p) { return p.around(components[i]); };  // includes itself
        const bool look = pairs_left >= components.size();
        if (look) pairs_left -= components.size();
        inside_out[i] = !look || std::count_if(components.begin(), components.end(), around) % 2 == 1;
      }
      out.volume += inside_out[i] ? -components[i].volume : components[i].volume;
      if (inside_out[i]) out.inverted += to_index(components[i].triangles);
    }
    out.components = components.size();
    if (out.inverted == 0) return;
    out.flip.assign(to_index(count), false);
    for (Index t = 0; t < count; ++t) out.flip[to_index(t)] = inside_out[to_index(component_at(3 * t))];
  }
};

}  // namespace

Winding check_orientation(std::span<const double> vertices, std::span<const std::int32_t> triangles,
                          const Topology& topology) {
  OrientationCheck check{vertices, triangles, topology, {}};
  if (!topology.inconsistent_pairs.empty()) check.make_consistent();
  if (check.out.flipped == 0) check.orient_outwards();
  return std::move(check.out);
}

void flip(std::vector<std::int32_t>& triangles, const std::vector<bool>& which) {
  for (std::size_t t = 0; t < which.size(); ++t)
    if (which[t]) std::swap(triangles[3 * t + 1], triangles[3 * t + 2]);
}

}  // namespace palpate::scene
