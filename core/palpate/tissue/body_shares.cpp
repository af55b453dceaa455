// How tetrahedra and patches share the energy (elements.hpp).
//
// Patches make thin bodies bend and twist as they should, and are too soft under loads as narrow as a cell. Thick
// bodies hardly bend, and are touched by such loads. The share of the patches therefore falls with the thickness of the
// body, counted in layers of nodes below its free surface: none in thick bodies, whose patches keep the volume alone.
// The shares are those with which bars, strips and flaps of two and more cells, up to nu = .495, bend and twist within
// 10 % of quadratic hexahedra (tests/tissue/test_bending.py).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "palpate/tissue/body.hpp"
#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

/// Share of the shear modulus that a patch takes, by the number of layers: one layer is two or three cells.
constexpr std::array kPatchShare = {0.825, 0.825, 0.6, 0.3, 0.0};
constexpr int kMostLayers = static_cast<int>(kPatchShare.size()) - 1;
// Bulk modulus that a tetrahedron keeps, over itself and over the shear modulus: the smaller of both. It suppresses
// pressures that alternate between nodes.
constexpr double kOwnBulk = 0.5, kOwnBulkOverShear = 0.4;

}  // namespace

// Counts the layers at each node: the steps from the free surface along edges, and the most of them that a node has
// within as many steps. Nodes that are fixed belong to no free surface.
void Body::find_layers() {
  layers_.assign(node_count(), kMostLayers);
  for (const std::int32_t node : data_.surface)
    if (data_.fixed.empty() || data_.fixed[to_index(node)] == 0) layers_[to_index(node)] = 0;
  const auto sweep = [&](auto&& join) {
    const std::vector<std::int32_t> before = layers_;
    for (std::size_t t = 0; t < tet_count(); ++t)
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < 4; ++b) {
          std::int32_t& at = layers_[to_index(data_.tets[4 * t + a])];
          at = join(at, before[to_index(data_.tets[4 * t + b])]);
        }
  };
  for (int k = 0; k < kMostLayers; ++k)
    sweep([](std::int32_t here, std::int32_t there) { return std::min(here, there + 1); });
  for (int k = 0; k < kMostLayers; ++k)
    sweep([](std::int32_t here, std::int32_t there) { return std::max(here, there); });
}

// Shares the moduli. A patch takes its share of the softest shear modulus around it, so that a stiff part does not grow
// by the patches at its border; it takes the means of the bulk moduli and of the Prony terms.
void Body::share_moduli() {
  const std::size_t n = node_count(), m = tet_count();
  own_mu_ = data_.mu;
  own_bulk_.resize(m);
  patch_mu_.assign(n, HUGE_VAL);
  patch_bulk_.assign(n, 0.0);
  mean_mu_ = mean_yeoh_ = patch_bulk_;
  for (std::size_t t = 0; t < m; ++t) {
    own_bulk_[t] = std::min(kOwnBulk * data_.bulk[t], kOwnBulkOverShear * data_.mu[t]);
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t node = to_index(data_.tets[4 * t + c]);
      const double weight = volume_[t] / 4.0 / patch_volume_[node];
      patch_bulk_[node] += weight * (data_.bulk[t] - own_bulk_[t]);
      mean_mu_[node] += weight * data_.mu[t];
      mean_yeoh_[node] += weight * data_.yeoh[t];
      patch_mu_[node] = std::min(patch_mu_[node], kPatchShare[to_index(layers_[node])] * data_.mu[t]);
    }
  }
  for (std::size_t k = 0; k < 4 * m; ++k) own_mu_[k / 4] -= patch_mu_[to_index(data_.tets[k])] / 4.0;
}

}  // namespace palpate::tissue
