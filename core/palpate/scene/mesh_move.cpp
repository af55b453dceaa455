// A mesh whose vertices move: normals and the BVH follow; adjacency and creases stay those at rest.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "palpate/scene/mesh_impl.hpp"
#include "palpate/types/index.hpp"

namespace palpate::scene {
namespace {

constexpr float kOutwards = 0x1p-22F;  // relative margin of a bound, for the rounding to single precision

Bvh copy_of(const Bvh& from) {
  Bvh to;
  to.node_count = from.node_count;
  to.block_count = from.block_count;
  to.nodes.reset(new BvhNode[from.node_count]);
  to.blocks.reset(new TriangleBlock[from.block_count]);
  to.ids.reset(new std::int32_t[from.block_count * kTrianglesPerBlock]);
  std::copy_n(from.nodes.get(), from.node_count, to.nodes.get());
  std::copy_n(from.blocks.get(), from.block_count, to.blocks.get());
  std::copy_n(from.ids.get(), from.block_count * kTrianglesPerBlock, to.ids.get());
  std::copy_n(from.centre, 3, to.centre);
  to.scale = from.scale;
  return to;
}

/// Normals of all fans of triangles, weighted as in topology.cpp.
void refresh_normals(Mesh::Impl& m) noexcept {
  Topology& topology = m.topology;
  const std::span<double> normals = topology.normals.own();
  std::fill(normals.begin(), normals.end(), 0.0);
  const auto triangles = static_cast<std::int32_t>(m.triangles.size() / 3);
  for (std::int32_t t = 0; t < triangles; ++t) {
    const Vec3 a = m.corner(3 * t), b = m.corner(3 * t + 1), c = m.corner(3 * t + 2);
    const Vec3 area = (b - a).cross(c - a);
    const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
    const double all = ab * bc * ca;
    if (!(all > 0.0)) continue;
    const double share[3] = {bc / all, ca / all, ab / all};
    for (std::int32_t k = 0; k < 3; ++k)
      Eigen::Map<Vec3>(&normals[3 * to_index(topology.normal[to_index(3 * t + k)])]) += share[k] * area;
  }
  for (std::size_t i = 0; i < normals.size(); i += 3) {
    Eigen::Map<Vec3> n(&normals[i]);
    const double length = n.norm();
    n = length > 0.0 ? Vec3(n / length) : Vec3(Vec3::UnitZ());
  }
  topology.height = 0.0;
  for (std::int32_t t = 0; t < triangles; ++t) {
    const Vec3 x[3] = {m.corner(3 * t), m.corner(3 * t + 1), m.corner(3 * t + 2)};
    const Vec3 n[3] = {m.normal(3 * t), m.normal(3 * t + 1), m.normal(3 * t + 2)};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 e = x[(k + 1) % 3] - x[k];
      const double from = e.dot(n[k]), to = e.dot(n[(k + 1) % 3]);
      topology.height = std::max(topology.height, std::abs(to - from) / 4.0 + std::abs(to + from) / 8.0);
    }
  }
}

/// Bounds of a triangle block in the coordinates of the BVH; fills the block.
void refill(Mesh::Impl& m, std::size_t index, float lo[3], float hi[3]) noexcept {
  TriangleBlock& block = m.bvh.blocks[index];
  for (std::size_t k = 0; k < 3; ++k) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t lane = 0; lane < kTrianglesPerBlock; ++lane) {
      const std::size_t t = to_index(m.bvh.ids[index * kTrianglesPerBlock + lane]);
      double x[3];
      for (std::size_t c = 0; c < 3; ++c) x[c] = m.vertices[3 * to_index(m.triangles[3 * t + c]) + k];
      block.a[k][lane] = x[0];
      block.e1[k][lane] = x[1] - x[0];
      block.e2[k][lane] = x[2] - x[0];
      low = std::min({low, x[0], x[1], x[2]});
      high = std::max({high, x[0], x[1], x[2]});
    }
    lo[k] = static_cast<float>((low - m.bvh.centre[k]) * m.bvh.scale);
    hi[k] = static_cast<float>((high - m.bvh.centre[k]) * m.bvh.scale);
    lo[k] -= kOutwards * (std::abs(lo[k]) + kOutwards);
    hi[k] += kOutwards * (std::abs(hi[k]) + kOutwards);
  }
}

/// Bounds of all nodes, from the last to the root: a child comes after its parent. The discs are not used any more.
void refit(Mesh::Impl& m) noexcept {
  for (std::size_t i = m.bvh.node_count; i-- > 0;) {
    BvhNode& node = m.bvh.nodes[i];
    for (int lane = 0; lane < 8; ++lane) {
      if (node.child[lane] == 0) continue;  // unused
      float lo[3], hi[3];
      if (node.child[lane] < 0) {
        refill(m, to_index(~node.child[lane]), lo, hi);
      } else {
        const BvhNode& child = m.bvh.nodes[to_index(node.child[lane])];
        for (int k = 0; k < 3; ++k) {
          lo[k] = *std::min_element(child.lo[k], child.lo[k] + 8);
          hi[k] = *std::max_element(child.hi[k], child.hi[k] + 8);
        }
      }
      for (int k = 0; k < 3; ++k) {
        node.lo[k][lane] = lo[k];
        node.hi[k][lane] = hi[k];
        node.centre[k][lane] = node.normal[k][lane] = 0.0F;
      }
      node.radius[lane] = std::numeric_limits<float>::infinity();
      node.half[lane] = 0.0F;
    }
  }
}

}  // namespace

std::shared_ptr<Mesh> Mesh::movable() const {
  std::shared_ptr<Mesh> copy(new Mesh);
  Impl& m = *copy->impl_;
  m.vertices = impl_->vertices;
  m.triangles = impl_->triangles;
  m.topology = impl_->topology;
  m.bvh = copy_of(impl_->bvh);
  m.report = impl_->report;
  return copy;
}

void Mesh::move(std::span<const double> vertices) noexcept {
  Impl& m = *impl_;
  double farthest2 = 0.0;
  for (std::size_t i = 0; i < m.vertices.size(); i += 3)
    farthest2 = std::max(farthest2, (Vec3(&vertices[i]) - Vec3(&m.vertices[i])).squaredNorm());
  m.travelled += std::sqrt(farthest2);
  std::copy(vertices.begin(), vertices.end(), m.vertices.own().begin());
  refresh_normals(m);
  refit(m);
}

}  // namespace palpate::scene
