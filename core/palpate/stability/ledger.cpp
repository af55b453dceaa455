#include "palpate/stability/ledger.hpp"

namespace palpate::stability {

const Energy& Ledger::step(const Vec3& p_LH, const PortForces& forces, double spring) noexcept {
  if (started_) {
    const Vec3 dx = p_LH - p_LH_;
    energy_.port -= forces_.F_H_L.dot(dx);
    energy_.damping -= forces_.F_damping.dot(dx);
    energy_.cut -= forces_.F_cut.dot(dx);
  }
  started_ = true;
  p_LH_ = p_LH;
  forces_ = forces;
  energy_.spring = spring;
  return energy_;
}

double spring_energy(const contact::ContactSet& contacts, double stiffness_scale) noexcept {
  double energy = 0.0;
  for (int i = 0; i < contacts.size; ++i) {
    const contact::Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    const Vec3& K = c.material.K;
    energy += 0.5 * stiffness_scale * c.delta_x.dot(K.cwiseProduct(c.delta_x));
  }
  return energy;
}

}  // namespace palpate::stability
