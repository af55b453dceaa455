// The MTM's gripper: a passive hinge whose angle is measured. It reports when it is pinched and when it opens.
#pragma once

#include "dvrk/outbox.hpp"

namespace palpate::dvrk {

/// Detects pinching and opening of the gripper.
class Gripper {
 public:
  static constexpr double kZero = 0.0;       ///< largest angle of a closed gripper [rad]
  static constexpr double kDebounce = 0.05;  ///< time for which a change must last before it is reported [s]

  /// One servo period of dt [s] with the measured angle [rad].
  void run(double angle, double dt, const Voice& voice) noexcept {
    const bool closed = angle <= kZero;
    if (closed != closed_) {
      closed_ = closed;
      waited_ = 0.0;
      told_ = false;
    }
    if (told_) return;
    waited_ += dt;
    if (waited_ < kDebounce) return;
    told_ = true;
    voice.flag(Topic::gripper_closed, closed_);
    if (closed_) voice.say(Topic::gripper_pinch);
  }

 private:
  bool closed_ = false, told_ = false;
  double waited_ = 0.0;
};

}  // namespace palpate::dvrk
