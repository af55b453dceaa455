// Construction of a body: checks, blocks of tetrahedra, masses and the time step.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include "palpate/tissue/body.hpp"
#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kBarrier = 4.0;                   // [k] modulus of the barrier against inversion
constexpr double kSafety = 0.8;                    // of the stable step at rest, because compression stiffens
constexpr std::array kSteps = {1, 2, 3, 4, 6, 8};  // steps per tick to choose from

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument("tissue: " + what); }

void check_each(const std::vector<double>& values, std::size_t n, const char* name, double lowest, bool open) {
  if (values.size() != n)
    refuse(std::string(name) + " has " + std::to_string(values.size()) + " values for " + std::to_string(n) +
           (n == 1 ? " entry" : " entries"));
  for (std::size_t i = 0; i < n; ++i) {
    if (std::isfinite(values[i]) && (open ? values[i] > lowest : values[i] >= lowest)) continue;
    refuse(std::string(name) + "[" + std::to_string(i) + "] = " + std::to_string(values[i]) + " must be " +
           (open ? "above " : "at least ") + std::to_string(lowest));
  }
}

void check_indices(const std::vector<std::int32_t>& rows, std::size_t width, std::size_t n, const char* name) {
  if (rows.size() % width != 0) refuse(std::string(name) + " is not a list of rows of " + std::to_string(width));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i] >= 0 && to_index(rows[i]) < n) continue;
    refuse(std::string(name) + "[" + std::to_string(i / width) + "] names node " + std::to_string(rows[i]) +
           ", there are " + std::to_string(n));
  }
}

/// A tetrahedron at rest.
struct Rest {
  double volume;              ///< negative if it is inverted [m^3]
  std::array<Vec3, 4> slope;  ///< gradients of the shape functions of the corners [1/m]
};

Rest rest_of(const BodyData& data, std::size_t t) {
  const auto corner = [&](std::size_t k) { return Vec3(&data.nodes[3 * to_index(data.tets[4 * t + k])]); };
  const Vec3 first = corner(0), a = corner(1) - first, b = corner(2) - first, c = corner(3) - first;
  const Vec3 bc = b.cross(c), ca = c.cross(a), ab = a.cross(b);
  const double six = a.dot(bc), scale = 1.0 / six;
  return {six / 6.0, {-scale * (bc + ca + ab), scale * bc, scale * ca, scale * ab}};
}

using Triple = std::array<double, 3>;

/// Eigenvalues of the symmetric matrix with the diagonal d and the entries o = (12, 20, 01), the largest first: the
/// roots of its characteristic polynomial in trigonometric form (Smith 1961, Commun. ACM 4).
Triple eigenvalues(Triple d, const Triple& o) {
  const double mean = (d[0] + d[1] + d[2]) / 3.0;
  double square = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    d[i] -= mean;
    square += d[i] * d[i] + 2.0 * o[i] * o[i];
  }
  const double p = std::sqrt(square / 6.0);
  if (!(p > 0.0)) return {mean, mean, mean};
  const double det =
      d[0] * d[1] * d[2] + 2.0 * o[0] * o[1] * o[2] - d[0] * o[0] * o[0] - d[1] * o[1] * o[1] - d[2] * o[2] * o[2];
  const double angle = std::acos(std::clamp(det / (2.0 * p * p * p), -1.0, 1.0)) / 3.0;
  constexpr double kThird = 2.0 * std::numbers::pi / 3.0;
  return {mean + 2.0 * p * std::cos(angle), mean + 2.0 * p * std::cos(angle - kThird),
          mean + 2.0 * p * std::cos(angle + kThird)};
}

/// Largest squared frequency of a tetrahedron with its own lumped mass [1/s^2].
///
/// A stress sigma makes the forces sigma g_a on the corners, which have the gradients g_a, and these cause the stress
/// lambda tr(sigma M) I + mu (sigma M + M sigma), M = sum g_a g_a^T. In the principal axes of M, with eigenvalues m_i,
/// this map has the eigenvalues mu (m_i + m_j) on shears and those of 2 mu diag(m) + lambda sqrt(m m^T) on the
/// diagonal.
double largest_frequency2(const std::array<Vec3, 4>& slope, double lambda, double mu, double density) {
  Triple diagonal{}, mixed{};
  for (const Vec3& g : slope)
    for (int i = 0; i < 3; ++i) {
      diagonal[to_index(i)] += g[i] * g[i];
      mixed[to_index(i)] += g[(i + 1) % 3] * g[(i + 2) % 3];
    }
  const Triple m = eigenvalues(diagonal, mixed);
  for (std::size_t i = 0; i < 3; ++i) {
    diagonal[i] = (2.0 * mu + lambda) * m[i];
    mixed[i] = lambda * std::sqrt(std::max(m[(i + 1) % 3] * m[(i + 2) % 3], 0.0));
  }
  return std::max(mu * (m[0] + m[1]), eigenvalues(diagonal, mixed)[0]) * 4.0 / density;
}

/// Sets the material of a lane: moduli [Pa], c [-], volume [m^3].
void set_material(MaterialBlock& material, std::size_t lane, double mu, double bulk, double yeoh, double volume) {
  material.shear[lane] = static_cast<float>(mu * volume);
  material.bulk[lane] = static_cast<float>((bulk + mu / 3.0) * volume);
  material.yeoh[lane] = static_cast<float>(yeoh);
}

void set_corner(CornerBlock& corner, std::size_t lane, std::uint32_t row, const Vec3& slope) {
  corner.row[lane] = row;
  for (Eigen::Index i = 0; i < 3; ++i) corner.slope[i][lane] = static_cast<float>(slope[i]);
}

}  // namespace

Body::Body(BodyData data)
    : data_(std::move(data)), kernel_(data_.portable || !has_avx2() ? portable_kernel() : avx2_kernel()) {
  check();
  const std::size_t n = node_count();
  u_.assign(3 * n, 0.0);
  v_ = load_ = u_;
  loaded_.assign(n, 0);
  u32_.assign(n + 1, Four{});
  v32_ = force_ = u32_;
  measure();
  find_layers();
  share_moduli();
  make_tets();
  make_patches();
  choose_step(frequencies2());
  for (int parts = 1; parts <= 2; ++parts)
    for (const PronyTerm& term : data_.prony) {
      Viscosity& viscosity = viscosity_[parts - 1];
      const auto k = viscosity.terms++;
      const double decay = data_.step / (parts * term.tau), recover = -std::expm1(-decay);
      viscosity.share[k] = static_cast<float>(term.g * recover / decay);
      viscosity.recover[k] = static_cast<float>(recover);
    }
  history_.assign(patches_.size() * data_.prony.size(), HistoryBlock{});
  reset();
}

void Body::check() const {
  const std::size_t n = node_count(), m = tet_count();
  if (m == 0) refuse("no tetrahedra");
  if (data_.nodes.size() % 3 != 0) refuse("nodes is not a list of points");
  for (std::size_t i = 0; i < data_.nodes.size(); ++i)
    if (!std::isfinite(data_.nodes[i])) refuse("nodes[" + std::to_string(i / 3) + "] is not finite");
  check_indices(data_.tets, 4, n, "tets");
  check_indices(data_.surface, 3, n, "surface");
  check_each(data_.mu, m, "mu", 0.0, true);
  check_each(data_.bulk, m, "bulk", 0.0, true);
  check_each(data_.density, m, "density", 0.0, true);
  check_each(data_.yeoh, m, "yeoh", 0.0, false);
  if (!data_.fixed.empty() && data_.fixed.size() != n)
    refuse("fixed has " + std::to_string(data_.fixed.size()) + " values for " + std::to_string(n) + " nodes");
  if (!data_.spring.empty()) check_each(data_.spring, n, "spring", 0.0, false);
  if (data_.prony.size() > to_index(kMaxProny))
    refuse(std::to_string(data_.prony.size()) + " Prony terms; at most " + std::to_string(kMaxProny));
  double total = 0.0;
  for (const PronyTerm& term : data_.prony) {
    check_each({term.g}, 1, "prony g", 0.0, false);
    check_each({term.tau}, 1, "prony tau", kShortestTau, false);
    if (term.tau > kLongestTau)
      refuse("prony tau = " + std::to_string(term.tau) + " s must be at most " + std::to_string(kLongestTau));
    total += term.g;
  }
  if (total > kLargestShare)
    refuse("the sum of prony g is " + std::to_string(total) + ", at most " + std::to_string(kLargestShare));
  check_each({data_.step}, 1, "step", 0.0, false);
  check_each({data_.tick}, 1, "tick", 0.0, true);
  check_each({data_.damping}, 1, "damping", 0.0, false);
  check_each({data_.mass_limit}, 1, "mass_limit", 0.0, false);
}

// Volumes of tetrahedra and patches.
void Body::measure() {
  volume_.resize(tet_count());
  patch_volume_.assign(node_count(), 0.0);
  least_height_ = HUGE_VAL;
  for (std::size_t t = 0; t < volume_.size(); ++t) {
    const auto [volume, slope] = rest_of(data_, t);
    if (!(volume > 0.0))
      refuse("tetrahedron " + std::to_string(t) + " has the volume " + std::to_string(1e9 * volume) +
             " mm^3: it is flat or inverted; mesh the surface again");
    if (!(data_.bulk[t] > data_.mu[t] / 3.0))
      refuse("bulk[" + std::to_string(t) + "] is too small for this shear modulus");
    volume_[t] = volume;
    for (const Vec3& g : slope) least_height_ = std::min(least_height_, 1.0 / g.norm());
    for (std::size_t c = 0; c < 4; ++c) patch_volume_[to_index(data_.tets[4 * t + c])] += volume / 4.0;
  }
  for (std::size_t i = 0; i < patch_volume_.size(); ++i)
    if (!(patch_volume_[i] > 0.0)) refuse("node " + std::to_string(i) + " belongs to no tetrahedron");
}

// Fills the blocks of tetrahedra. Neighbours among them come to different blocks, so that the lanes of a block do not
// wait for each other when they add to the same node.
void Body::make_tets() {
  const std::size_t m = tet_count(), count = (m + kWide - 1) / kWide;
  tets_.assign(count, ElementBlock{});
  corners_.assign(3 * count, CornerBlock{});
  for (std::size_t b = 0; b < count; ++b) {
    tets_[b].first = static_cast<std::uint32_t>(3 * b);
    tets_[b].last = static_cast<std::uint32_t>(3 * b + 3);
  }
  for (std::size_t t = 0; t < m; ++t) {
    const std::size_t b = t % count, lane = t / count;
    const auto row = [&](std::size_t c) { return static_cast<std::uint32_t>(4 * data_.tets[4 * t + c]); };
    const std::array<Vec3, 4> slope = rest_of(data_, t).slope;
    tets_[b].row[lane] = row(0);
    for (std::size_t c = 1; c < 4; ++c) set_corner(corners_[3 * b + c - 1], lane, row(c), slope[c]);
    MaterialBlock& material = tets_[b].material;
    set_material(material, lane, own_mu_[t], own_bulk_[t], data_.yeoh[t], volume_[t]);
    const double k = data_.bulk[t] + data_.mu[t] / 3.0;
    material.barrier[lane] = static_cast<float>(kBarrier * k * volume_[t]);
  }
}

// Fills the blocks of patches, those with equally many corners side by side. The gradient of a patch is the mean of
// those of its tetrahedra by their volumes.
void Body::make_patches() {
  const std::size_t n = node_count();
  std::vector<std::map<std::int32_t, Vec3>> slopes(n);  // of each patch by the other nodes
  for (std::size_t t = 0; t < tet_count(); ++t) {
    const std::array<Vec3, 4> slope = rest_of(data_, t).slope;
    const std::int32_t* const corner = &data_.tets[4 * t];
    for (std::size_t c = 0; c < 4; ++c)
      for (std::size_t d = 0; d < 4; ++d)
        if (d != c)
          slopes[to_index(corner[c])].try_emplace(corner[d], Vec3::Zero()).first->second +=
              volume_[t] / (4.0 * patch_volume_[to_index(corner[c])]) * slope[d];
  }
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return slopes[a].size() < slopes[b].size(); });
  patches_.assign((n + kWide - 1) / kWide, ElementBlock{});
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = order[k], lane = k % kWide;
    ElementBlock& block = patches_[k / kWide];
    if (lane == 0) {
      const std::size_t widest = slopes[order[std::min(k + kWide, n) - 1]].size();
      block.first = static_cast<std::uint32_t>(corners_.size());
      corners_.resize(corners_.size() + widest);
      block.last = static_cast<std::uint32_t>(corners_.size());
    }
    block.row[lane] = static_cast<std::uint32_t>(4 * i);
    std::size_t at = block.first;
    for (const auto& [node, slope] : slopes[i])
      set_corner(corners_[at++], lane, static_cast<std::uint32_t>(4 * node), slope);
    while (at < block.last) corners_[at++].row[lane] = block.row[lane];
    set_material(block.material, lane, patch_mu_[i], patch_bulk_[i], mean_yeoh_[i], patch_volume_[i]);
    block.material.viscous[lane] = static_cast<float>(mean_mu_[i] * patch_volume_[i]);
  }
}

// Largest squared frequency of each tetrahedron [1/s^2], just after a sudden deformation. The energy of a patch is at
// most that of its tetrahedra with its moduli, by Jensen's inequality. At rest, those of the shear are the tetrahedra's
// own; the means that patches take of the bulk modulus and for the Prony terms are above them beside a stiff part.
std::vector<double> Body::frequencies2() const {
  double relaxing = 0.0;
  for (const PronyTerm& term : data_.prony) relaxing += term.g;
  std::vector<double> out(tet_count());
  for (std::size_t t = 0; t < out.size(); ++t) {
    double bulk = own_bulk_[t], viscous = 0.0;
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t node = to_index(data_.tets[4 * t + c]);
      bulk += patch_bulk_[node] / 4.0;
      viscous += mean_mu_[node] / 4.0;
    }
    const double mu = data_.mu[t] + relaxing * std::max(viscous, data_.mu[t]);
    out[t] = largest_frequency2(rest_of(data_, t).slope, std::max(bulk, data_.bulk[t]) - 2.0 / 3.0 * mu, mu,
                                data_.density[t]);
  }
  return out;
}

// Chooses the time step and adds mass where a tetrahedron is too stiff for it: the largest frequency of a mesh is at
// most that of its tetrahedra alone, so that scaling the mass of each bounds it (Olovsson and others 2005).
void Body::choose_step(const std::vector<double>& frequency2) {
  stable_step_ = 2.0 / std::sqrt(*std::max_element(frequency2.begin(), frequency2.end()));
  const auto scale = [&](std::size_t t, double dt) {
    return std::max(1.0, dt * dt * frequency2[t] / (4.0 * kSafety * kSafety));
  };
  const auto added = [&](double dt) {
    double mass = 0.0, more = 0.0;
    for (std::size_t t = 0; t < volume_.size(); ++t) {
      mass += data_.density[t] * volume_[t];
      more += data_.density[t] * volume_[t] * (scale(t, dt) - 1.0);
    }
    return more / mass;
  };
  if (data_.step > 0.0) {
    steps_ = std::max(1, static_cast<int>(std::lround(data_.tick / data_.step)));
  } else {
    for (const int steps : kSteps) {
      steps_ = steps;
      if (added(data_.tick / steps) <= data_.mass_limit) break;
    }
    data_.step = data_.tick / steps_;
  }
  added_mass_ = added(data_.step);
  mass_.assign(node_count(), 0.0);
  for (std::size_t t = 0; t < volume_.size(); ++t)
    for (std::size_t c = 0; c < 4; ++c)
      mass_[to_index(data_.tets[4 * t + c])] += data_.density[t] * volume_[t] * scale(t, data_.step) / 4.0;
  inverse_mass_.resize(mass_.size());
  for (std::size_t i = 0; i < mass_.size(); ++i)
    inverse_mass_[i] = !data_.fixed.empty() && data_.fixed[i] != 0 ? 0.0 : 1.0 / mass_[i];
}

}  // namespace palpate::tissue
