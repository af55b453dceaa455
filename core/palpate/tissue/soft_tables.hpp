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
  bool rounded = false;            ///< the smooth surface lies beside the facets somewhere
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

/// Position of a vertex of the touched surface X + K u. u: displacements, 3 numbers a node [m].
[[nodiscard]] Vec3 position_of(const SoftTables& tables, std::int32_t vertex, std::span<const double> u) noexcept;

}  // namespace palpate::tissue
