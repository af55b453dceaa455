// The energy ledger: what the hand put in, where it is, and what the caps kept from it (B1).
#pragma once

#include "palpate/contact/contact.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::stability {

/// All at the hand's port, so that the entries add up [J].
struct Energy {
  double port = 0.0;     ///< taken from the hand by the rendered force; below zero it was generated
  double spring = 0.0;   ///< stored in the contacts' springs
  double damping = 0.0;  ///< dissipated by the damping term
  double cut = 0.0;      ///< would have been taken, too, without the caps
};

/// The wrenches of one tick, on the hand in L.
struct PortForces {
  Wrench F_H_L;      ///< rendered
  Wrench F_damping;  ///< of the force law, mapped to the hand
  Wrench F_cut;      ///< wanted minus rendered
};

/// The force of tick k acts until tick k+1, while the hand moves from x_k to x_k+1. So, exactly, for a force that is
/// held:
///
///   E_k+1 = E_k - F_k . (x_k+1 - x_k) - t_k . (turn from R_k to R_k+1)
///
/// (Hannaford and Ryu's passivity observer with the force that was really there, not the next one.)
/// In slow contact without friction port + cut = spring + damping.
class Ledger {
 public:
  /// X_LH: handle at this tick; forces: of this tick, acting from now on; spring: energy stored now [J].
  const Energy& step(const Pose& X_LH, const PortForces& forces, double spring) noexcept;

 private:
  bool started_ = false;
  Pose X_LH_;
  PortForces forces_;
  Energy energy_;
};

/// 1/2 delta_x^T K delta_x over the contacts, on the tool's side [J].
[[nodiscard]] double spring_energy(const contact::ContactSet& contacts, double stiffness_scale) noexcept;

}  // namespace palpate::stability
