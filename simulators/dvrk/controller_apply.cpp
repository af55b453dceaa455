// Dispatch of the commands from the bus.
#include "dvrk/controller.hpp"

namespace palpate::dvrk {

bool Controller::apply(const Command& c) noexcept { return apply_servo(c) || apply_move(c) || apply_option(c); }

bool Controller::apply_servo(const Command& c) noexcept {
  switch (c.verb) {
    case Verb::servo_jp:
      servo_jp(c.position, c.velocity);
      return true;
    case Verb::servo_jr:
      servo_jr(c.position);
      return true;
    case Verb::servo_cp:
      servo_cp(c.X, c.V);
      return true;
    case Verb::servo_cr:
      servo_cr(c.X);
      return true;
    case Verb::servo_cs:
      servo_cs(c);
      return true;
    case Verb::servo_jf:
      servo_jf(c.effort);
      return true;
    case Verb::body_servo_cf:
      body_servo_cf(c.F);
      return true;
    case Verb::spatial_servo_cf:
      servo_cf("spatial_servo_cf", Cf::spatial, c.F);
      return true;
    case Verb::servo_ci:
      effort_.impedance = c.impedance;
      servo_cf("servo_cf_body", Cf::impedance, {});
      return true;
    case Verb::hold:
      hold();
      return true;
    case Verb::free:
      free();
      return true;
    default:
      return false;
  }
}

bool Controller::apply_move(const Command& c) noexcept {
  switch (c.verb) {
    case Verb::move_jp:
      move_jp(c.position);
      return true;
    case Verb::move_jr:
      move_jr(c.position);
      return true;
    case Verb::move_cp:
      move_cp(c.X);
      return true;
    case Verb::jaw_servo_jp:
      jaw_servo_jp(c.position[0]);
      return true;
    case Verb::jaw_move_jp:
      jaw_move_jp(c.position[0]);
      return true;
    case Verb::jaw_servo_jf:
      jaw_servo_jf(c.effort[0]);
      return true;
    default:
      return false;
  }
}

bool Controller::apply_option(const Command& c) noexcept {
  switch (c.verb) {
    case Verb::set_ratio:
    case Verb::set_ratio_v:
    case Verb::set_ratio_a:
      set_ratio(c.verb, c.value);
      return true;
    case Verb::use_gravity_compensation:
      use_gravity_compensation(c.flag);
      return true;
    case Verb::body_set_cf_orientation_absolute:
      body_set_cf_orientation_absolute(c.flag);
      return true;
    case Verb::lock_orientation:
      lock_orientation(c.X.R);
      return true;
    case Verb::unlock_orientation:
      unlock_orientation();
      return true;
    default:
      return false;
  }
}

}  // namespace palpate::dvrk
