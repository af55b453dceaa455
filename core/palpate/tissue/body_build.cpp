// Construction of a body: checks, blocks of tetrahedra, masses and the time step.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include "palpate/tissue/body.hpp"
#include "palpate/types/index.hpp"

namespace palpate::tissue {
namespace {

constexpr double kOwnShare = 0.1;  // of the volume term that a tetrahedron computes alone; it suppresses checkerboards
constexpr double kSafety = 0.8;    // of the stable step at rest, because compression stiffens
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
  make_blocks();
  list_around();
  for (int parts = 1; parts <= 2; ++parts)
    for (const PronyTerm& term : data_.prony) {
      Viscosity& viscosity = viscosity_[parts - 1];
      const auto k = viscosity.terms++;
      viscosity.share[k] = static_cast<float>(term.g);
      viscosity.recover[k] = static_cast<float>(-std::expm1(-data_.step / (parts * term.tau)));
    }
  history_.assign(blocks_.size() * data_.prony.size(), HistoryBlock{});
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
  for (const PronyTerm& term : data_.prony) {
    check_each({term.g}, 1, "prony g", 0.0, false);
    check_each({term.tau}, 1, "prony tau", 0.0, true);
  }
  check_each({data_.step}, 1, "step", 0.0, false);
  check_each({data_.tick}, 1, "tick", 0.0, true);
  check_each({data_.damping}, 1, "damping", 0.0, false);
  check_each({data_.mass_limit}, 1, "mass_limit", 0.0, false);
}

// Fills the blocks and sums the volumes of the nodes. Neighbours among the tetrahedra come to different blocks, so that
// the lanes of a block do not wait for each other when they add to the same node.
void Body::make_blocks() {
  const std::size_t n = node_count(), m = tet_count();
  const std::size_t count = (m + kWide - 1) / kWide;
  blocks_.assign(count, ElementBlock{});
  std::vector<double> node_volume(n, 0.0);
  node_bulk_.assign(n, 0.0);
  least_height_ = HUGE_VAL;
  for (std::size_t t = 0; t < m; ++t) {
    const auto [volume, slope] = rest_of(data_, t);
    if (!(volume > 0.0))
      refuse("tetrahedron " + std::to_string(t) + " has the volume " + std::to_string(1e9 * volume) +
             " mm^3: it is flat or inverted; mesh the surface again");
    const double mu = data_.mu[t], lambda = data_.bulk[t] - 2.0 / 3.0 * mu, k = lambda + mu;
    if (!(lambda > -mu / 3.0)) refuse("bulk[" + std::to_string(t) + "] is too small for this shear modulus");
    for (const Vec3& g : slope) least_height_ = std::min(least_height_, 1.0 / g.norm());
    ElementBlock& block = blocks_[t % count];
    const std::size_t lane = t / count;
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t node = to_index(data_.tets[4 * t + c]);
      block.row[c][lane] = static_cast<std::uint32_t>(4 * node);
      node_volume[node] += volume / 4.0;
      node_bulk_[node] += (1.0 - kOwnShare) * k * volume / 4.0;
    }
    for (std::size_t i = 0; i < 9; ++i)
      block.slope[i][lane] = static_cast<float>(slope[i / 3 + 1][static_cast<Eigen::Index>(i % 3)]);
    block.shear[lane] = static_cast<float>(mu * volume);
    block.bulk[lane] = static_cast<float>(kOwnShare * k * volume);
    block.volume[lane] = static_cast<float>(volume);
    block.yeoh[lane] = static_cast<float>(data_.yeoh[t]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!(node_volume[i] > 0.0)) refuse("node " + std::to_string(i) + " belongs to no tetrahedron");
    node_bulk_[i] /= node_volume[i];
  }
  choose_step(frequencies2());
  for (std::size_t i = 0; i < n; ++i) node_bulk_[i] /= node_volume[i];
}

// Largest squared frequency of each tetrahedron [1/s^2]. The energy of the averaged pressures is at most that of the
// tetrahedra with the mean modulus of their corners, by Jensen's inequality; beside a stiff part it is above their own.
std::vector<double> Body::frequencies2() const {
  double instantaneous = 1.0;
  for (const PronyTerm& term : data_.prony) instantaneous += term.g;
  std::vector<double> out(tet_count());
  for (std::size_t t = 0; t < out.size(); ++t) {
    const double mu = data_.mu[t], own = data_.bulk[t] + mu / 3.0;
    double k = kOwnShare * own;
    for (std::size_t c = 0; c < 4; ++c) k += node_bulk_[to_index(data_.tets[4 * t + c])] / 4.0;
    out[t] = largest_frequency2(rest_of(data_, t).slope, std::max(k, own) - mu, mu * instantaneous, data_.density[t]);
  }
  return out;
}

// Lists the tetrahedra around each node.
void Body::list_around() {
  dilatation_.assign(blocks_.size() * kWide, 0.0F);
  first_.assign(node_count() + 1, 0);
  for (const std::int32_t node : data_.tets) ++first_[to_index(node) + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  around_.resize(data_.tets.size());
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t k = 0; k < data_.tets.size(); ++k)
    around_[to_index(next[to_index(data_.tets[k])]++)] =
        static_cast<std::int32_t>(kWide * (k / 4 % blocks_.size()) + k / 4 / blocks_.size());
}

// Chooses the time step and adds mass where a tetrahedron is too stiff for it: the largest frequency of a mesh is at
// most that of its tetrahedra alone, so that scaling the mass of each bounds it (Olovsson and others 2005).
void Body::choose_step(const std::vector<double>& frequency2) {
  stable_step_ = 2.0 / std::sqrt(*std::max_element(frequency2.begin(), frequency2.end()));
  std::vector<double> volume(tet_count());
  for (std::size_t t = 0; t < volume.size(); ++t)
    volume[t] = static_cast<double>(blocks_[t % blocks_.size()].volume[t / blocks_.size()]);
  const auto scale = [&](std::size_t t, double dt) {
    return std::max(1.0, dt * dt * frequency2[t] / (4.0 * kSafety * kSafety));
  };
  const auto added = [&](double dt) {
    double mass = 0.0, more = 0.0;
    for (std::size_t t = 0; t < volume.size(); ++t) {
      mass += data_.density[t] * volume[t];
      more += data_.density[t] * volume[t] * (scale(t, dt) - 1.0);
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
  for (std::size_t t = 0; t < volume.size(); ++t)
    for (std::size_t c = 0; c < 4; ++c)
      mass_[to_index(data_.tets[4 * t + c])] += data_.density[t] * volume[t] * scale(t, data_.step) / 4.0;
  inverse_mass_.resize(mass_.size());
  for (std::size_t i = 0; i < mass_.size(); ++i)
    inverse_mass_[i] = !data_.fixed.empty() && data_.fixed[i] != 0 ? 0.0 : 1.0 / mass_[i];
}

}  // namespace palpate::tissue
