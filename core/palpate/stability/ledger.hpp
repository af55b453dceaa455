// The energy ledger: what the hand put in, where it is, and what each element of the stage kept from it.
#pragma once

#include <array>

#include "palpate/stability/delay_line.hpp"
#include "palpate/types/contact.hpp"
#include "palpate/types/spatial.hpp"
#include "palpate/types/status.hpp"

namespace palpate::stability {

/// All at the hand's port, so that the entries add up [J].
struct Energy {
  double port = 0.0;     ///< taken from the hand by the rendered force; below zero it was generated
  double spring = 0.0;   ///< stored in the contacts' springs
  double damping = 0.0;  ///< dissipated by the damping term
  // What would have been taken, too, without ...
  double cut = 0.0;                       ///< the caps
  double passivity = 0.0;                 ///< the passivity controller
  double low_pass = 0.0;                  ///< the low-pass
  double coupling = 0.0;                  ///< the virtual coupling
  std::array<double, kSources> source{};  ///< wanted by each source: their sum is port and the four above
};

/// The wrenches of one tick, on the hand in L.
struct PortForces {
  Wrench F_H_L;      ///< rendered
  Wrench F_damping;  ///< of the force law, mapped to the hand
  // Each element's input minus its output; of the caps: the drives' limits, too.
  Wrench F_cut, F_passivity, F_low_pass, F_coupling;
  std::array<Wrench, kSources> F_source{};
};

/// The force of tick k acts from t_k + delay until the next one does, while the hand moves. So, exactly, for a force
/// that is held and a delay of d whole periods:
///
///   E_k+1 = E_k - F_k-d . (x_k+1 - x_k) - t_k-d . (turn from R_k to R_k+1)
///
/// (Hannaford and Ryu's passivity observer with the force that was really there, not the next one.)
/// In slow contact without friction port + cut + passivity + low_pass + coupling = spring + damping.
class Ledger {
 public:
  /// delay: known, of the loop; dt: period [s].
  explicit Ledger(double delay = 0.0, double dt = 1e-3) : line_(delay, dt) {}

  /// X_LH: handle at this tick; forces: of this tick, sent now; spring: energy stored now [J].
  const Energy& step(const Pose& X_LH, const PortForces& forces, double spring) noexcept;

 private:
  void book(const PortForces& forces, const Vec3& dx, const Vec3& turn, double share) noexcept;

  bool started_ = false;
  Pose X_LH_;
  DelayLine<PortForces> line_;
  Energy energy_;
};

/// 1/2 delta_x^T K delta_x over the contacts, on the tool's side [J].
[[nodiscard]] double spring_energy(const ContactSet& contacts, double stiffness_scale) noexcept;
/// Stiffness of all contacts together along a force F, f = F / |F|: sum of (f . n)^2 n^T K n, on the tool's side [N/m].
[[nodiscard]] double stiffness_along(const Vec3& F, const ContactSet& contacts, double stiffness_scale) noexcept;

}  // namespace palpate::stability
