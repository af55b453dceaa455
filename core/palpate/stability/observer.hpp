// The passivity observer: what the hand has surely put into the port, and what is still on its way back.
#pragma once

#include "palpate/stability/delay_line.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::stability {

struct ObserverOptions {
  double delay = 0.0;                   ///< from measurement to torque, all that is known of it [s]
  double quantum = 0.0;                 ///< resolution of the handle's position [m]
  double allowance = 5e-4;              ///< may be given beyond what came in [J]
  double capacity = 0.03;               ///< more than this is not remembered, but by an observer without a tank [J]
  double acceleration = 5.0;            ///< nobody snatches the handle, no force throws it faster [m/s^2]
  double angular_acceleration = 100.0;  ///< nor turns it [rad/s^2]
};

/// A ramp to zero: how fast a force and a moment can be taken back.
struct Ramp {
  double force = 0.0;   ///< [N/s]
  double moment = 0.0;  ///< [N m/s]
};

/// Hannaford and Ryu's observer (2002) with the force that was really there (Ryu, Kim, Hannaford 2004), which with a
/// delay is one sent earlier:
///
///   E_k+1 = min(E_k - F_k-d . (x_k+1 - x_k) - t_k-d . (turn from R_k to R_k+1) + D_k, capacity),   E_0 = allowance
///
/// with d the delay in periods (the two forces of a fraction in their shares) and D_k what the device surely
/// dissipated. x is the measured position seen through a play of half-width (quantum - |v| dt) / 2: a slow hand moves
/// from edge to edge of the encoder, where x is exact; a fast one passes whole counts, where the middle is right on the
/// average. A plain sum over counts would lose K quantum^2 per count and never find it again.
///
/// What is in flight acts later, on a motion nobody knows: it may cost as much as a hand can get out of it that moves
/// as now and then snatches the handle away with `acceleration`. The velocity is the mean of the last period.
class Observer {
 public:
  /// dt: period [s]. Throws std::invalid_argument naming an option that cannot be.
  Observer(const ObserverOptions& options, double dt);

  /// X_LH, V_LH: handle at this tick; dissipated: by the device since the last one [J].
  void step(const Pose& X_LH, const Twist& V_LH, double dissipated) noexcept;
  /// What this tick sends: acts after the delay.
  void sent(const Wrench& F_H_L) noexcept;
  /// Resets a deficit to the allowance, once nothing acts and nothing is in flight.
  void clear_deficit() noexcept;
  /// Credits the energy [J] of a potential that was switched on where the hand is: the hand did not put it in, but the
  /// port may give it. The account is not raised above `most`. Returns the energy credited.
  double credit(double energy, double most) noexcept;

  /// What may be given back [J].
  [[nodiscard]] double stored() const noexcept { return stored_; }
  /// Most that the wrenches sent before may still give to the hand [J].
  [[nodiscard]] double in_flight() const noexcept;
  /// Most that `F_H_L`, sent now and taken back by `ramp` from the next tick on, may give [J].
  [[nodiscard]] double cost(const Wrench& F_H_L, const Ramp& ramp) const noexcept;

 private:
  [[nodiscard]] double held(const Wrench& F, double from, double to) const noexcept;

  ObserverOptions options_;
  double dt_, delay_;
  DelayLine<Wrench> line_;
  std::size_t quiet_ = 0;  ///< periods since something was sent
  bool started_ = false;
  Pose X_LH_;  ///< through the play
  Twist V_LH_;
  double stored_;
};

/// Most that a constant force of size F may give over [from, to], when the hand's speed along it is at most u + a t now
/// and later: F integral of max(0, u + a t) dt [J].
[[nodiscard]] double held_cost(double F, double u, double a, double from, double to) noexcept;
/// The same of a ramp from F at `from` down to zero at `rate`.
[[nodiscard]] double ramp_cost(double F, double u, double a, double from, double rate) noexcept;

}  // namespace palpate::stability
