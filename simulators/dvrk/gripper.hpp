// The MTM's gripper: a passive hinge that is only measured; it tells when it was pinched and when it opened.
#pragma once

#include "dvrk/outbox.hpp"

namespace palpate::dvrk {

class Gripper {
 public:
  static constexpr double kZero = 0.0;       ///< at or below it is closed [rad]
  static constexpr double kDebounce = 0.05;  ///< so long, before it is told [s]

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
