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
  void run(double angle, double dt, const EventPublisher& publisher) noexcept {
    const bool closed = angle <= kZero;
    if (closed != closed_) {
      closed_ = closed;
      waited_ = 0.0;
      reported_ = false;
    }
    if (reported_) return;
    waited_ += dt;
    if (waited_ < kDebounce) return;
    reported_ = true;
    publisher.flag(Topic::gripper_closed, closed_);
    if (closed_) publisher.publish(Topic::gripper_pinch);
  }

 private:
  bool closed_ = false, reported_ = false;
  double waited_ = 0.0;
};

}  // namespace palpate::dvrk
