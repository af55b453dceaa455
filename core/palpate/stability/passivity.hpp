// The passivity controller: it starts no wrench whose cost may exceed the energy in the observer's account.
#pragma once

#include "palpate/stability/friction.hpp"
#include "palpate/stability/limiter.hpp"
#include "palpate/stability/observer.hpp"

namespace palpate::stability {

/// Modes of the controller.
enum class Passivity {
  off,
  observer,  ///< all energy that the hand has ever put in may be returned
  tank,      ///< at most `capacity` may be returned, so that energy put in long ago does not permit oscillation now
};

/// Options of the controller.
struct PassivityOptions {
  Passivity mode = Passivity::observer;
  ObserverOptions observer;  ///< its capacity limits the account in mode `tank` only; it always limits credits
  CertainFriction friction;  ///< certified friction of the device
};

/// Renders the largest fraction s of the wanted wrench F such that
///
///   in flight + cost(limiter output for s F) <= stored
///
/// The cost includes the ramp to zero, because the limiter can remove a wrench only by a ramp. By induction, as long as
/// the hand accelerates no faster than the bound, an immediate ramp to zero is always paid for. The port therefore
/// never returns more energy than came in, plus the allowance. The controller is the series damper of Hannaford and Ryu
/// with two limits: it acts before the deficit, not after it, and it reduces the wrench but never reverses it, because
/// a surface does not pull.
class PassivityController {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  PassivityController(const PassivityOptions& options, const Caps& caps, double dt);

  /// Updates the account with the motion since the last tick. q: measured joints, for the device's friction; may be
  /// empty.
  void observe(const Pose& X_LH, const Twist& V_LH, const JointVector& q) noexcept;
  /// Returns s F for a finite F.
  [[nodiscard]] Wrench step(const Wrench& F_H_L, const Limiter& limiter) noexcept;
  /// To be called while the mapping is released (clutch, a silent arm): see Observer::clear_deficit.
  void clear_deficit() noexcept { observer_.clear_deficit(); }
  /// Credits energy to the account [J]: see Observer::credit.
  void credit(double energy) noexcept { credited_ += observer_.credit(energy, credit_limit_); }
  /// Reports the wrench that the device renders in this tick.
  void rendered(const Wrench& F_H_L) noexcept { observer_.sent(F_H_L); }

  /// Energy in the account [J].
  [[nodiscard]] double stored() const noexcept { return observer_.stored(); }
  /// Energy credited since the start [J].
  [[nodiscard]] double credited() const noexcept { return credited_; }
  /// Largest energy that the wrenches in flight, including that of the last step(), may return to the hand [J].
  [[nodiscard]] double reserved() const noexcept { return reserved_; }

 private:
  Passivity mode_;
  RampDownRates ramp_down_;
  Observer observer_;
  Dissipation dissipation_;
  double credit_limit_;  ///< level of the account up to which energy is credited, in all modes [J]
  double credited_ = 0.0, reserved_ = 0.0;
};

}  // namespace palpate::stability
