#include "palpate/tissue/soft_tables.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <stdexcept>

#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kWidth = 0.7;  // [edge] of the spread force

/// The surface as a mesh that can move, without the inner nodes.
std::shared_ptr<const scene::Mesh> mesh_of(const BodyData& data) {
  if (data.surface.empty()) throw std::invalid_argument("tissue: surface has no triangles");
  std::vector<std::int32_t> row(data.nodes.size() / 3, -1), triangles;
  std::vector<double> vertices;
  for (const std::int32_t node : data.surface) {
    if (row[to_index(node)] < 0) {
      row[to_index(node)] = static_cast<std::int32_t>(vertices.size() / 3);
      const auto at = data.nodes.begin() + 3 * static_cast<std::ptrdiff_t>(node);
      vertices.insert(vertices.end(), at, at + 3);
    }
    triangles.push_back(row[to_index(node)]);
  }
  return scene::Mesh::build(vertices, triangles)->movable();
}

/// Node for each vertex of the mesh, which may have been welded and reordered: the one at the same position.
std::vector<std::int32_t> nodes_of(const scene::Mesh& mesh, const BodyData& data) {
  std::map<std::array<double, 3>, std::int32_t> node_at;
  for (const std::int32_t node : data.surface) {
    const double* const x = &data.nodes[3 * to_index(node)];
    node_at[{x[0], x[1], x[2]}] = node;
  }
  std::vector<std::int32_t> out;
  const std::span<const double> x = mesh.vertices();
  for (std::size_t i = 0; i < x.size(); i += 3) out.push_back(node_at.at({x[i], x[i + 1], x[i + 2]}));
  return out;
}

double mean_edge(const scene::Mesh& mesh) {
  const scene::Mesh::Impl& m = mesh.impl();
  double sum = 0.0;
  const auto count = static_cast<std::int32_t>(m.triangles.size());
  for (std::int32_t he = 0; he < count; ++he) sum += (m.corner(scene::next_half_edge(he)) - m.corner(he)).norm();
  return sum / count;
}

}  // namespace

SoftTables::SoftTables(const BodyData& data, double width)
    : rest(mesh_of(data)), node(nodes_of(*rest, data)), edge(mean_edge(*rest)) {
  spreading = Spreading(rest->vertices(), rest->triangles(), width > 0.0 ? width : kWidth * edge);
  rounded = rest->impl().topology.height > 1e-6 * edge;
  moduli = DepthModuli(*rest, data, edge, spreading.width());
  first.push_back(0);
  for (std::size_t i = 0; i < node.size(); ++i) {
    for (const Spreading::Entry& e : spreading.row(static_cast<std::int32_t>(i)))
      weights.push_back({node[to_index(e.vertex)], static_cast<float>(e.weight)});
    first.push_back(weights.size());
  }
}

Vec3 position_of(const SoftTables& tables, std::int32_t vertex, std::span<const double> u) noexcept {
  const std::size_t i = to_index(vertex);
  Vec3 x(&tables.rest->vertices()[3 * i]);
  for (std::size_t k = tables.first[i]; k < tables.first[i + 1]; ++k) {
    const SoftTables::NodeWeight& e = tables.weights[k];
    x += static_cast<double>(e.weight) * Vec3(&u[3 * to_index(e.node)]);
  }
  return x;
}

}  // namespace palpate::tissue
