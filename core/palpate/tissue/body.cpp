#include "palpate/tissue/body.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/types/denormals.hpp"
#include "palpate/types/index.hpp"

namespace palpate::tissue {

void Body::reset() noexcept {
  std::fill(u_.begin(), u_.end(), 0.0);
  std::fill(v_.begin(), v_.end(), 0.0);
  std::fill(u32_.begin(), u32_.end(), Four{});
  std::fill(v32_.begin(), v32_.end(), Four{});
  std::fill(history_.begin(), history_.end(), HistoryBlock{});
  clear_loads();
  nodes_.energy = fastest_ = 0.0;
  nodes_.least_volume = 1.0;
}

void Body::add_load(std::int32_t node, const Vec3& force) noexcept {
  const std::size_t i = to_index(node);
  if (loaded_count_ < loaded_.size()) loaded_[loaded_count_++] = node;
  for (std::size_t k = 0; k < 3; ++k) load_[3 * i + k] += force[static_cast<Eigen::Index>(k)];
}

void Body::clear_loads() noexcept {
  if (loaded_count_ == loaded_.size()) {
    std::fill(load_.begin(), load_.end(), 0.0);
  } else {
    for (std::size_t i = 0; i < loaded_count_; ++i)
      std::fill_n(load_.begin() + 3 * static_cast<std::ptrdiff_t>(loaded_[i]), 3, 0.0);
  }
  loaded_count_ = 0;
}

void Body::set_state(std::span<const double> displacements, std::span<const double> velocities) noexcept {
  std::copy(displacements.begin(), displacements.end(), u_.begin());
  std::copy(velocities.begin(), velocities.end(), v_.begin());
  for (std::size_t i = 0; i < u_.size(); ++i) {
    u32_[i / 3].x[i % 3] = static_cast<float>(u_[i]);
    v32_[i / 3].x[i % 3] = static_cast<float>(v_[i]);
  }
}

void Body::find_forces(const Viscosity& viscosity) noexcept {
  std::fill(force_.begin(), force_.end(), Four{});
  nodes_ = {u32_[0].x, force_[0].x};
  kernel_({tets_.data(), tets_.size(), corners_.data(), nullptr, {}}, nodes_);
  const double least_volume = nodes_.least_volume;
  kernel_({patches_.data(), patches_.size(), corners_.data(), history_.data(), viscosity}, nodes_);
  nodes_.least_volume = least_volume;
}

void Body::step(int parts) noexcept {
  const DenormalsAreZero scope;
  find_forces(viscosity_[parts > 1 ? 1 : 0]);
  integrate(data_.step / (parts > 1 ? 2 : 1));
}

// Symplectic Euler steps of the nodes, with the damping implicit.
void Body::integrate(double dt) noexcept {
  const double keep = 1.0 / (1.0 + dt * data_.damping);
  double fastest2 = 0.0;
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    const double scale = dt * inverse_mass_[i], spring = data_.spring.empty() ? 0.0 : data_.spring[i];
    double moved2 = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t j = 3 * i + k;
      const double force = static_cast<double>(force_[i].x[k]) + load_[j] - spring * u_[j];
      v_[j] = keep * (v_[j] + scale * force);
      const double move = dt * v_[j];
      u_[j] += move;
      u32_[i].x[k] = static_cast<float>(u_[j]);
      v32_[i].x[k] = static_cast<float>(v_[j]);
      moved2 += move * move;
    }
    fastest2 = moved2 <= fastest2 ? fastest2 : moved2;  // keeps a NaN
  }
  fastest_ = std::sqrt(fastest2);
}

void Body::internal_forces(std::span<double> out) noexcept {
  find_forces({});
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<double>(force_[i / 3].x[i % 3]);
}

BodyEnergy Body::energy() const noexcept {
  BodyEnergy e{nodes_.energy, 0.0};
  for (std::size_t i = 0; i < mass_.size(); ++i) {
    const double* const u = &u_[3 * i];
    const double* const v = &v_[3 * i];
    e.kinetic += 0.5 * mass_[i] * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!data_.spring.empty()) e.potential += 0.5 * data_.spring[i] * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  }
  return e;
}

}  // namespace palpate::tissue
