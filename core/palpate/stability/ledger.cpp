#include "palpate/stability/ledger.hpp"

#include "palpate/types/so3.hpp"

namespace palpate::stability {

const Energy& Ledger::step(const Pose& X_LH, const PortForces& forces, double spring, double released,
                           double dt) noexcept {
  if (started_) {
    const double last = now_;
    now_ += dt > 0.0 ? dt : dt_;
    const Vec3 dx = X_LH.p - X_LH_.p;
    const Vec3 turn = rotation_vector(X_LH.R * X_LH_.R.transpose());
    line_.acted(last, now_, [&](const PortForces& F, double fraction) noexcept { book(F, dx, turn, fraction); });
  }
  started_ = true;
  X_LH_ = X_LH;
  line_.push(now_, forces);
  energy_.spring = spring;
  energy_.mapping += released;
  return energy_;
}

void Ledger::book(const PortForces& forces, const Vec3& dx, const Vec3& turn, double fraction) noexcept {
  const auto take = [&](double& entry, const Wrench& F) noexcept { entry -= fraction * (F.f.dot(dx) + F.t.dot(turn)); };
  take(energy_.port, forces.F_H_L);
  take(energy_.damping, forces.F_damping);
  take(energy_.cut, forces.F_cut);
  take(energy_.passivity, forces.F_passivity);
  take(energy_.low_pass, forces.F_low_pass);
  take(energy_.coupling, forces.F_coupling);
  for (std::size_t i = 0; i < energy_.source.size(); ++i) take(energy_.source[i], forces.F_source[i]);
}

double spring_energy(const ContactSet& contacts, double stiffness_scale) noexcept {
  double energy = 0.0;
  for (int i = 0; i < contacts.size; ++i) {
    energy += stiffness_scale * palpate::spring_energy(contacts.contact[static_cast<std::size_t>(i)]);
  }
  return energy;
}

double stiffness_along(const Vec3& F, const ContactSet& contacts, double stiffness_scale) noexcept {
  const double size = F.norm();
  if (!(size > 0.0)) return 0.0;
  double sum = 0.0;
  for (int i = 0; i < contacts.size; ++i) {
    const Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    const double share = c.normal.dot(F) / size;
    sum += share * share * stiffness_scale * c.stiffening * c.normal.dot(c.material.K.cwiseProduct(c.normal));
  }
  return sum;
}

}  // namespace palpate::stability
