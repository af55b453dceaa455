// The passivity controller: no wrench is begun that the port could not pay for.
#pragma once

#include "palpate/stability/friction.hpp"
#include "palpate/stability/limiter.hpp"
#include "palpate/stability/observer.hpp"

namespace palpate::stability {

enum class Passivity {
  off,
  observer,  ///< the hand may have back all that it ever put in
  tank,      ///< no more than the tank holds: what the hand put in long ago is no licence to oscillate now
};

struct PassivityOptions {
  Passivity mode = Passivity::observer;
  ObserverOptions observer;  ///< its capacity counts in mode `tank` alone
  CertainFriction friction;  ///< the device's, as far as it is certain
};

/// The largest share s of the wanted wrench such that
///
///   in flight + cost(what the limiter would render of s F) <= stored
///
/// where the cost counts the ramp by which alone the limiter can take a wrench back. So, by induction, as long as the
/// hand accelerates no faster than assumed, ramping down at once is always paid for, and what the port has given never
/// exceeds what came in by more than the allowance. Hannaford and Ryu's series damper with two limits: it acts
/// before the deficit, not after it, and takes from the wrench but never turns it round (a surface does not pull).
class PassivityController {
 public:
  /// dt: period [s]. Throws std::invalid_argument naming an option that cannot be.
  PassivityController(const PassivityOptions& options, const Caps& caps, double dt);

  /// What has happened since the last tick. q: measured joints, for the device's friction; may be empty.
  void observe(const Pose& X_LH, const Twist& V_LH, const JointVector& q) noexcept;
  /// s F; F finite.
  [[nodiscard]] Wrench step(const Wrench& F_H_L, const Limiter& limiter) noexcept;
  /// The hand is disengaged (clutch, a silent arm): see Observer::clear_deficit.
  void clear_deficit() noexcept { observer_.clear_deficit(); }
  /// See Observer::credit.
  void credit(double energy) noexcept { credited_ += observer_.credit(energy, credit_limit_); }
  void rendered(const Wrench& F_H_L) noexcept { observer_.sent(F_H_L); }

  [[nodiscard]] double stored() const noexcept { return observer_.stored(); }
  /// Energy credited since the start [J].
  [[nodiscard]] double credited() const noexcept { return credited_; }
  /// What the wrenches on their way, the last one sent among them, may cost [J].
  [[nodiscard]] double reserved() const noexcept { return reserved_; }

 private:
  Passivity mode_;
  Ramp ramp_;
  Observer observer_;
  Dissipation dissipation_;
  double credit_limit_;  ///< level of the account up to which energy is credited, in either mode [J]
  double credited_ = 0.0, reserved_ = 0.0;
};

}  // namespace palpate::stability
