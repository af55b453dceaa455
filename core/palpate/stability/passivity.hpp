// The passivity controller: it starts no wrench whose cost may exceed the energy in the observer's account.
#pragma once

#include "palpate/stability/friction.hpp"
#include "palpate/stability/limiter.hpp"
#include "palpate/stability/observer.hpp"

namespace palpate::stability {

/// Modes of the controller.
enum class Passivity {
  off,
  observer,  ///< at most what the springs store now, and a reserve for removing the wrench, may be returned
  tank,      ///< at most `capacity` may be returned
};

/// Options of the controller.
struct PassivityOptions {
  Passivity mode = Passivity::observer;
  ObserverOptions observer;
  CertainFriction friction;    ///< certified friction of the device
  double capacity = 0.03;      ///< largest energy in the account in mode `tank`; it limits credits in all modes [J]
  double speed = 0.3;          ///< fastest motion along the largest force for which `reserve` pays [m/s]
  double angular_speed = 3.0;  ///< the same for a rotation along the largest moment [rad/s]
};

/// Largest cost of any wrench within the caps, in flight or sent now, and of its ramp to zero, while the handle moves
/// along it no faster than `speed` and `angular_speed` when it is sent; and the allowance [J]. lag: of the filter
/// before the controller [s]. dt: period [s].
[[nodiscard]] double reserve(const PassivityOptions& options, const Caps& caps, double lag, double dt) noexcept;

/// Renders the largest fraction s of the wanted wrench F such that
///
///   in flight + cost(limiter output for s F) <= stored
///
/// The cost includes the ramp to zero, because the limiter can remove a wrench only by a ramp. By induction, as long as
/// the hand accelerates no faster than the bound, an immediate ramp to zero is always paid for. The port therefore
/// never returns more energy than came in, plus the allowance. The controller is the series damper of Hannaford and Ryu
/// with two limits: it acts before the deficit, not after it, and it reduces the wrench but never reverses it, because
/// a surface does not pull.
///
/// The account is limited, so that energy put in long ago does not permit oscillation now. A wrench that is the
/// gradient of a potential returns at most the potential that is stored now, and its removal costs at most `reserve`:
///
///   stored <= potential + reserve     (mode `tank`: stored <= capacity)
class PassivityController {
 public:
  /// lag: of the filter before the controller [s]. dt: period of the cycle [s]. Throws std::invalid_argument naming an
  /// invalid option.
  PassivityController(const PassivityOptions& options, const Caps& caps, double lag, double dt);

  /// Updates the account with the motion since the last tick. q: measured joints, for the device's friction; may be
  /// empty. potential: energy that the rendered springs store now, at the hand's port; infinity: unknown [J].
  void observe(const Pose& X_LH, const Twist& V_LH, const JointVector& q, double potential) noexcept;
  /// Returns s F for a finite F.
  [[nodiscard]] Wrench step(const Wrench& F_H_L, const Limiter& limiter) noexcept;
  /// To be called while the mapping is released (clutch, a silent arm): see Observer::clear_deficit.
  void clear_deficit() noexcept { observer_.clear_deficit(); }
  /// Credits energy to the account [J]: see Observer::credit.
  void credit(double energy) noexcept { credited_ += observer_.credit(energy, capacity_); }
  /// Reports the wrench that the device renders in this tick.
  void rendered(const Wrench& F_H_L) noexcept { observer_.sent(F_H_L); }

  /// Energy in the account [J].
  [[nodiscard]] double stored() const noexcept { return observer_.stored(); }
  /// Energy credited since the start [J].
  [[nodiscard]] double credited() const noexcept { return credited_; }
  /// Energy that the account may hold beyond the potential, in mode `observer` [J].
  [[nodiscard]] double reserve() const noexcept { return reserve_; }
  /// Largest energy that the wrenches in flight, including that of the last step(), may return to the hand [J].
  [[nodiscard]] double reserved() const noexcept { return reserved_; }

 private:
  Passivity mode_;
  RampDownRates ramp_down_;
  Observer observer_;
  Dissipation dissipation_;
  double capacity_, reserve_;
  double credited_ = 0.0, reserved_ = 0.0;
};

}  // namespace palpate::stability
