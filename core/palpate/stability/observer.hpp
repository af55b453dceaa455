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

/// The observer of Hannaford and Ryu (2002) with the force that really acted (Ryu, Kim and Hannaford 2004); with a
/// delay that is a force sent earlier:
///
///   E_k+1 = E_k - F_acting . (x_k+1 - x_k) - t_acting . (turn from R_k to R_k+1) + D_k,   E_0 = allowance
///
/// A slow hand needs many periods for one count. So up to one quantum of x_k+1 - x_k is the motion of all periods since
/// the measured position last changed, and F_acting is for it the mean of the forces that acted in them: behind a delay
/// a part of the motion still has the force of the count before. D_k is the certified dissipation of the device. x is
/// the measured position after a backlash (hysteresis) of half-width (quantum - |v| dt) / 2. For a slow hand x moves
/// from edge to edge of the encoder, where it is exact; for a fast hand it is the middle of a count, which is right on
/// average. A plain sum over counts would lose K quantum^2 / 2 per count.
///
/// Forces in flight act later, on an unknown motion. Their cost is the largest energy that a hand could extract by
/// continuing at the present velocity and then accelerating at the bound `acceleration`. The velocity is the larger of
/// the reported one and the mean of the last period.
class Observer {
 public:
  /// dt: nominal period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  Observer(const ObserverOptions& options, double dt);

  /// Updates the account. X_LH, V_LH: handle at this tick. dissipated: by the device since the last tick [J]. dt: time
  /// since the last tick [s].
  void step(const Pose& X_LH, const Twist& V_LH, double dissipated, double dt) noexcept;
  /// Reports the wrench that this tick sends; it acts after the delay.
  void sent(const Wrench& F_H_L) noexcept;
  /// Adds energy to the account [J]; negative: takes it.
  void add(double energy) noexcept { stored_ += energy; }

  /// Energy in the account, which may be returned to the hand [J].
  [[nodiscard]] double stored() const noexcept { return stored_; }
  /// Largest energy that the wrenches already sent may still return to the hand [J].
  [[nodiscard]] double in_flight() const noexcept;
  /// Largest energy that `F_H_L`, sent now, held for `hold` [s] and then faded out within kFade, may return [J].
  [[nodiscard]] double cost(const Wrench& F_H_L, double hold) const noexcept;

 private:
  [[nodiscard]] double held(const Wrench& F, double from, double to) const noexcept;

  ObserverOptions options_;
  double dt_, now_ = 0.0;  ///< nominal period, and time of the last tick [s]
  DelayLine<Wrench> line_;
  bool started_ = false;
  Pose X_LH_;                       ///< pose of the handle, its position after the backlash
  Vec3 p_measured_ = Vec3::Zero();  ///< measured position, before the backlash
  Vec3 impulse_ = Vec3::Zero();     ///< of the forces that acted since it last changed [N s]
  double since_ = 0.0;              ///< time since then [s]
  Twist V_LH_, mean_;               ///< reported velocity of the handle, and its mean in the last period
  double stored_;
};

/// Time in which the controller fades a force out whose energy is spent [s].
inline constexpr double kFade = 0.004;

/// Largest energy that a constant force of magnitude F [N] returns over the times from..to [s] if the hand's speed
/// along it is at most u + a t: F times the integral of max(0, u + a t) dt [J]. u [m/s], a [m/s^2].
[[nodiscard]] double held_cost(double F, double u, double a, double from, double to) noexcept;
/// The same for a force that falls linearly from F at the time `from` to zero within `span` [s].
[[nodiscard]] double fade_cost(double F, double u, double a, double from, double span) noexcept;

}  // namespace palpate::stability
