// What the surface of a soft body is made from; all copies of the surface share it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "palpate/scene/mesh.hpp"
#include "palpate/scene/mesh_impl.hpp"
#include "palpate/tissue/body.hpp"
#include "palpate/tissue/depth_moduli.hpp"
#include "palpate/tissue/spreading.hpp"
#include "palpate/types/index.hpp"

namespace palpate::tissue {

/// The surface of a body at rest, with its relation to the nodes.
struct SoftTables {
  std::shared_ptr<const scene::Mesh> rest;  ///< the surface at rest
  Spreading spreading;
  std::vector<std::int32_t> node;  ///< node of the body for each vertex of the mesh
  double edge = 0.0;               ///< mean length of the edges [m]
  DepthModuli moduli;
  /// Rows of `spreading` as nodes with weights in single precision, for the mean under each vertex of the mesh.
  struct NodeWeight {
    std::int32_t node;
    float weight;
  };
  std::vector<NodeWeight> weights;
  std::vector<std::size_t> first;  ///< weights of vertex i: weights[first[i]] up to weights[first[i + 1]]

  /// width: of the spreading [m]; 0: chosen from the mean edge. Throws std::invalid_argument without a surface.
  SoftTables(const BodyData& data, double width);
};

/// A mean over the nodes under the spread load of a surface point. nodal: 3 numbers a node.
[[nodiscard]] Vec3 mean_under(const SoftTables& tables, const scene::SurfacePoint& at,
                              std::span<const double> nodal) noexcept;

/// Calls act(node, weight) for all nodes under the spread load of a surface point.
template <class Act>
void for_nodes_under(const SoftTables& tables, const scene::SurfacePoint& at, Act&& act) noexcept {
  const double b[3] = {at.u(), at.v, at.w};
  for (std::int32_t k = 0; k < 3; ++k) {
    const std::int32_t vertex = tables.rest->triangles()[to_index(3 * at.triangle + k)];
    for (const Spreading::Entry& e : tables.spreading.row(vertex))
      act(tables.node[to_index(e.vertex)], b[k] * e.weight);
  }
}

}  // namespace palpate::tissue
