// The passivity controller, the last element of the stage: it lets no wrench act whose cost may exceed the energy in
// the account.
#pragma once

#include <vector>

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
  double delay_doubt = 0.0;  ///< the true delay may exceed ObserverOptions::delay by up to this time [s]
  CertainFriction friction;  ///< certified friction of the device
  double capacity = 0.03;    ///< bound of the outstanding credit in all modes, and of the account in mode `tank` [J]
  /// Fraction of the work of moving surfaces and other instruments that the hand may receive, 0-1.
  double moving_share = 0.0;
  double speed = 0.3;          ///< fastest motion along the largest force for which `reserve` pays [m/s]
  double angular_speed = 3.0;  ///< the same for a rotation along the largest moment [rad/s]
};

/// Largest cost of any wrench within the caps, in flight or sent now, and of its removal, while the handle moves along
/// it no faster than `speed` and `angular_speed` when it is sent; and the allowance [J]. lag: of the filter before the
/// controller [s]. dt: period [s].
[[nodiscard]] double reserve(const PassivityOptions& options, const Caps& caps, double lag, double dt) noexcept;

/// Renders the largest fraction s of the limited wrench F such that
///
///   s cost(F)  <=  stored - in flight            cost: F acts for a period after the delay and is then faded out
///
/// or F itself if its cost is zero, which is so while the hand moves against F faster than it can turn around. The
/// controller is the last element and may therefore remove a wrench at once. By induction, as long as the hand
/// accelerates no faster than the bound, the port never returns more energy than came in, plus the allowance. The
/// controller is the series damper of Hannaford and Ryu with two limits: it acts before the deficit, not after it, and
/// it reduces the wrench but never reverses it, because a surface does not pull.
///
/// An uncertain delay: one account is kept for each of several delays between `delay` and `delay + delay_doubt`, and
/// the wrench must be paid for by each of them.
///
/// The account is limited, so that energy put in long ago does not permit oscillation now. A wrench that is the
/// gradient of a potential returns at most the potential that is stored now, and its removal costs at most `reserve`:
///
///   stored <= potential + reserve     (mode `tank`: stored <= capacity)
///
/// Where the potential falls by more than the motion explains, an object has disappeared. What the limit then takes,
/// and no credit needs, is set aside for `kAside` and comes back with the object.
///
/// Credit is a loan: energy beyond this limit repays it before it is discarded, and what is outstanding never exceeds
/// `capacity`. So for any sequence of motions, clutches and switches
///
///   energy that the hand has put in + certified dissipation  >=  - allowance - capacity    at every moment
///
/// With a `moving_share` that share of the work of moving surfaces and instruments stands on the left as well.
class PassivityController {
 public:
  /// lag: of the filter before the controller [s]. dt: nominal period of the cycle [s]. Throws std::invalid_argument
  /// naming an invalid option.
  PassivityController(const PassivityOptions& options, const Caps& caps, double lag, double dt);

  /// Updates the account with the motion since the last tick, dt ago [s]. q: measured joints, for the device's
  /// friction; may be empty. potential: energy that the rendered springs store now, at the hand's port; infinity:
  /// unknown [J].
  void observe(const Pose& X_LH, const Twist& V_LH, const JointVector& q, double potential, double dt) noexcept;
  /// Returns s F for a finite F.
  [[nodiscard]] Wrench step(const Wrench& F_H_L) noexcept;
  /// Credits energy to the account [J], of a potential that was switched on at the hand's position: the hand did not
  /// put it in, but the port may return it. The outstanding credit stays within the capacity.
  void credit(double energy) noexcept;
  /// Adds the share of the work [J] that moving surfaces and other instruments do on the hand.
  void share(double work) noexcept;
  /// Reports the wrench that the device renders in this tick.
  void rendered(const Wrench& F_H_L) noexcept;

  /// Energy in the account, for the least favourable delay [J].
  [[nodiscard]] double stored() const noexcept;
  /// Energy credited and not yet repaid [J].
  [[nodiscard]] double credited() const noexcept { return credited_; }
  /// Energy that the account may hold beyond the potential, in mode `observer` [J].
  [[nodiscard]] double reserve() const noexcept { return reserve_; }
  /// Largest energy that the wrenches in flight, including that of the last step(), may return to the hand [J].
  [[nodiscard]] double reserved() const noexcept { return reserved_; }
  /// True while the account is in deficit by more than rounding errors and counts: the hand or the loop left the
  /// assumed bounds, and the hand has got more energy than the guarantee allows.
  [[nodiscard]] bool in_deficit() const noexcept { return mode_ != Passivity::off && stored() < -kUnfelt; }

 private:
  static constexpr double kUnfelt = 5e-5;  ///< [J]

  static constexpr double kAside = 0.5;  ///< [s]

  double limit(double most) noexcept;
  void limit_to(double potential, const Pose& X_LH, double dt) noexcept;

  Passivity mode_;
  std::vector<Observer> observers_;  ///< one for each assumed delay
  Dissipation dissipation_;
  double dt_, hold_;  ///< nominal period; time for which a wrench may act until the next tick [s]
  double capacity_, moving_share_, reserve_;
  double credited_ = 0.0, reserved_ = 0.0;
  Wrench F_;                              ///< wrench of the last tick before the controller
  Pose X_LH_;                             ///< handle at the last tick
  double potential_ = 0.0;                ///< at the last tick [J]
  double aside_ = 0.0, aside_age_ = 0.0;  ///< energy set aside [J], and the time since then [s]
};

}  // namespace palpate::stability
