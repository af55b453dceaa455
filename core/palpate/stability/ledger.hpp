// The energy ledger: the energy that the hand has put in, where it is stored, and what each element of the stage
// withheld.
#pragma once

#include <array>

#include "palpate/stability/delay_line.hpp"
#include "palpate/types/contact.hpp"
#include "palpate/types/spatial.hpp"
#include "palpate/types/status.hpp"

namespace palpate::stability {

/// Energies since the start, all at the hand's port, so that the entries add up [J].
struct Energy {
  double port = 0.0;     ///< taken from the hand by the rendered force; negative if the force has generated energy
  double spring = 0.0;   ///< stored in the springs of the contacts
  double damping = 0.0;  ///< dissipated by the damping term
  double mapping = 0.0;  ///< released from the springs by motion of the tool that is not the hand's; never decreases
  // Energy that an element withheld: the work of its input minus its output.
  double cut = 0.0;                       ///< withheld by the caps and the drives' limits
  double passivity = 0.0;                 ///< withheld by the passivity controller
  double low_pass = 0.0;                  ///< withheld by the low-pass
  double coupling = 0.0;                  ///< withheld by the virtual coupling
  std::array<double, kSources> source{};  ///< of the wanted wrench by source; the sum is port plus the four above
};

/// The wrenches of one tick, on the hand in L.
struct PortForces {
  Wrench F_H_L;      ///< rendered wrench
  Wrench F_damping;  ///< damping term of the force law, mapped to the hand
  // Input minus output of each element; F_cut includes the loss by the drives' limits.
  Wrench F_cut, F_passivity, F_low_pass, F_coupling;
  std::array<Wrench, kSources> F_source{};  ///< wanted wrench of each source
};

/// The force of tick k acts from t_k + delay until the next force does, while the hand moves. For a force that is held
/// and a delay of d whole periods, this sum is exact; otherwise the forces that acted in a period count in proportion:
///
///   E_k+1 = E_k - F_k-d . (x_k+1 - x_k) - t_k-d . (turn from R_k to R_k+1)
///
/// It is the passivity observer of Hannaford and Ryu (2002) with the force that acted, not the next one.
/// In slow contact without friction, port + cut + passivity + low_pass + coupling = spring + damping + mapping.
class Ledger {
 public:
  /// delay: known delay of the loop [s]. dt: period of the cycle [s].
  explicit Ledger(double delay = 0.0, double dt = 1e-3) : dt_(dt), line_(delay, dt) {}

  /// X_LH: pose of the handle at this tick. forces: sent at this tick. spring: energy stored now [J].
  /// released: energy that the mapping released in this tick [J]. dt: time since the last tick; 0: one period [s].
  const Energy& step(const Pose& X_LH, const PortForces& forces, double spring, double released = 0.0,
                     double dt = 0.0) noexcept;

 private:
  void book(const PortForces& forces, const Vec3& dx, const Vec3& turn, double fraction) noexcept;

  double dt_, now_ = 0.0;  ///< period, time of the last tick [s]
  bool started_ = false;
  Pose X_LH_;
  DelayLine<PortForces> line_;
  Energy energy_;
};

/// Energy stored in the contacts on the tool's side, the sum of 1/2 delta_x^T K delta_x or Contact::stored [J].
[[nodiscard]] double spring_energy(const ContactSet& contacts, double stiffness_scale) noexcept;
/// Stiffness of all contacts along f = F / |F| on the tool's side, the sum of (f . n)^2 n^T K n, with the
/// tangent stiffness where K depends on the depth [N/m].
[[nodiscard]] double stiffness_along(const Vec3& F, const ContactSet& contacts, double stiffness_scale) noexcept;

}  // namespace palpate::stability
