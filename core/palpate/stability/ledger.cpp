#include "palpate/stability/ledger.hpp"

namespace palpate::stability {

namespace {

double work(const Wrench& F, const Vec3& dx, const Vec3& turn) noexcept { return F.f.dot(dx) + F.t.dot(turn); }

}  // namespace

const Energy& Ledger::step(const Pose& X_LH, const PortForces& forces, double spring) noexcept {
  if (started_) {
    const Vec3 dx = X_LH.p - X_LH_.p;
    const Eigen::AngleAxisd rotation(X_LH.R * X_LH_.R.transpose());
    const Vec3 turn = rotation.angle() * rotation.axis();
    energy_.port -= work(forces_.F_H_L, dx, turn);
    energy_.damping -= work(forces_.F_damping, dx, turn);
    energy_.cut -= work(forces_.F_cut, dx, turn);
  }
  started_ = true;
  X_LH_ = X_LH;
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
