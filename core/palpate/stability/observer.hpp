// The passivity observer: the certified energy that the hand has put into the port, and the energy that forces in
// flight may still return.
#pragma once

#include "palpate/stability/delay_line.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::stability {

/// Options of the observer.
struct ObserverOptions {
  double delay = 0.0;                   ///< known delay from measurement to torque [s]
  double quantum = 0.0;                 ///< resolution of the handle's position [m]
  double allowance = 5e-4;              ///< energy that may be returned beyond the energy put in [J]
  double acceleration = 5.0;            ///< bound on the acceleration of the handle by hand or force [m/s^2]
  double angular_acceleration = 100.0;  ///< the same bound for its rotation [rad/s^2]
};

/// Rates at which a force and a moment can be ramped to zero.
struct RampDownRates {
  double force = 0.0;   ///< [N/s]
  double moment = 0.0;  ///< [N m/s]
};

/// The observer of Hannaford and Ryu (2002) with the force that really acted (Ryu, Kim and Hannaford 2004); with a
/// delay that is a force sent earlier:
///
///   E_k+1 = E_k - F_k-d . (x_k+1 - x_k) - t_k-d . (turn from R_k to R_k+1) + D_k,   E_0 = allowance
///
/// d is the delay in periods (for a fraction of a period, two forces count in proportion), and D_k is the certified
/// dissipation of the device. x is the measured position after a backlash (hysteresis) of half-width
/// (quantum - |v| dt) / 2. For a slow hand x moves from edge to edge of the encoder, where it is exact; for a fast hand
/// it is the middle of a count, which is right on average. A plain sum over counts would lose K quantum^2 / 2 per
/// count.
///
/// Forces in flight act later, on an unknown motion. Their cost is the largest energy that a hand could extract by
/// continuing at the present velocity and then accelerating at the bound `acceleration`. The velocity is the mean of
/// the last period.
class Observer {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  Observer(const ObserverOptions& options, double dt);

  /// Updates the account. X_LH, V_LH: handle at this tick. dissipated: by the device since the last tick [J].
  void step(const Pose& X_LH, const Twist& V_LH, double dissipated) noexcept;
  /// Reports the wrench that this tick sends; it acts after the delay.
  void sent(const Wrench& F_H_L) noexcept;
  /// Discards the energy in the account beyond `most` [J].
  void limit(double most) noexcept;
  /// Resets a deficit to the allowance if no wrench acts or is in flight.
  void clear_deficit() noexcept;
  /// Credits the energy [J] of a potential that was switched on at the hand's position: the hand did not put it in, but
  /// the port may return it. The account is not raised above `most` [J]. Returns the energy credited.
  double credit(double energy, double most) noexcept;

  /// Energy in the account, which may be returned to the hand [J].
  [[nodiscard]] double stored() const noexcept { return stored_; }
  /// Largest energy that the wrenches already sent may still return to the hand [J].
  [[nodiscard]] double in_flight() const noexcept;
  /// Largest energy that `F_H_L`, sent now and ramped to zero at `rates` from the next tick on, may return [J].
  [[nodiscard]] double cost(const Wrench& F_H_L, const RampDownRates& rates) const noexcept;

 private:
  [[nodiscard]] double held(const Wrench& F, double from, double to) const noexcept;

  ObserverOptions options_;
  double dt_, delay_;
  DelayLine<Wrench> line_;
  std::size_t zero_periods_ = 0;  ///< periods since a wrench other than zero was sent
  bool started_ = false;
  Pose X_LH_;  ///< pose of the handle, its position after the backlash
  Twist V_LH_;
  double stored_;
};

/// Largest energy that a constant force of magnitude F [N] returns over the times from..to [s] if the hand's speed
/// along it is at most u + a t: F times the integral of max(0, u + a t) dt [J]. u [m/s], a [m/s^2].
[[nodiscard]] double held_cost(double F, double u, double a, double from, double to) noexcept;
/// The same for a ramp from F at the time `from` down to zero at `rate` [N/s].
[[nodiscard]] double ramp_cost(double F, double u, double a, double from, double rate) noexcept;

}  // namespace palpate::stability
