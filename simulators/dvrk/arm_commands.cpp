// What may be asked of an arm, and when it refuses.
#include <cmath>

#include "dvrk/arm.hpp"

namespace palpate::dvrk {
namespace {

bool is_finite(const Wrench& F) noexcept { return F.f.allFinite() && F.t.allFinite(); }
bool is_finite(const Twist& V) noexcept { return V.v.allFinite() && V.w.allFinite(); }
bool is_finite(const HalfPlane& h) noexcept {
  return h.p.allFinite() && h.d.allFinite() && h.bias.allFinite() && h.deadband.allFinite();
}
bool is_sound(const Impedance& i) noexcept {
  return is_rotation(i.R_force) && is_rotation(i.R_torque) && i.p_force.allFinite() && is_finite(i.position_positive) &&
         is_finite(i.position_negative) && is_finite(i.orientation_positive) && is_finite(i.orientation_negative);
}

bool is_jaw(Verb verb) noexcept {
  return verb == Verb::jaw_servo_jp || verb == Verb::jaw_move_jp || verb == Verb::jaw_servo_jf;
}

}  // namespace

bool Arm::apply(const Command& c) noexcept {
  for (const VerbEntry& entry : verbs()) {
    if (entry.verb != c.verb) continue;
    if (entry.kind != Kind::arm || (entry.arms & static_cast<unsigned>(spec_.kind)) == 0) return false;
    if (!takes(c, entry.payload)) {
      Text words(entry.name);
      words << " refused: ";
      if (entry.payload == Payload::joints) {
        words << "it needs " << (is_jaw(c.verb) ? 1L : static_cast<long>(n_)) << " finite numbers, one per joint";
      } else {
        words << "it needs finite numbers, and rotations that are rotations";
      }
      voice_.words(Topic::warning, words);
      return true;
    }
    return apply_motion(c) || apply_effort(c) || apply_rest(c);
  }
  return false;
}

// Does the payload hold what the verb can use?
bool Arm::takes(const Command& c, Payload payload) noexcept {
  const Eigen::Index n = is_jaw(c.verb) ? 1 : n_;
  switch (payload) {
    case Payload::joints: {
      const bool by_torque = c.verb == Verb::servo_jf || c.verb == Verb::jaw_servo_jf;
      const JointVector& main = by_torque ? c.effort : c.position;
      const bool velocity = c.velocity.size() == 0 || (c.velocity.size() == n && c.velocity.allFinite());
      return main.size() == n && main.allFinite() && (by_torque || velocity);
    }
    case Payload::pose:
      return is_pose(c.X);
    case Payload::rotation:
      return is_rotation(c.X.R);
    case Payload::wrench:
      return is_finite(c.F);
    case Payload::cartesian:
      return (!c.pose_is_valid || is_pose(c.X)) && (!c.twist_is_valid || is_finite(c.V)) &&
             (!c.wrench_is_valid || is_finite(c.F));
    case Payload::impedance:
      return is_sound(c.impedance);
    case Payload::value:
      return std::isfinite(c.value);
    default:
      return true;
  }
}

bool Arm::apply_motion(const Command& c) noexcept {
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
    case Verb::move_jp:
      move_jp(c.position);
      return true;
    case Verb::move_jr:
      move_jr(c.position);
      return true;
    case Verb::move_cp:
      move_cp(c.X);
      return true;
    case Verb::hold:
      hold();
      return true;
    case Verb::set_ratio:
    case Verb::set_ratio_v:
    case Verb::set_ratio_a:
      set_ratio(c.verb, c.value);
      return true;
    case Verb::jaw_servo_jp:
    case Verb::jaw_move_jp:
    case Verb::jaw_servo_jf:
      jaw(c);
      return true;
    default:
      return false;
  }
}

bool Arm::apply_effort(const Command& c) noexcept {
  switch (c.verb) {
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
      impedance_ = c.impedance;
      servo_cf("servo_cf_body", Cf::impedance, {});
      return true;
    case Verb::free:
      free();
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

bool Arm::apply_rest(const Command& c) noexcept {
  switch (c.verb) {
    case Verb::state_command:
      state_command(c.text.view());
      return true;
    case Verb::set_base_frame:
      base_frame_ = c.X;
      return true;
    case Verb::set_tool_type:
      instrument_.set_tool_type(c.text, voice_);
      return true;
    case Verb::emulate_adapter_present:
      instrument_.set_adapter_present(c.flag, voice_);
      return true;
    case Verb::emulate_tool_present:
      instrument_.set_tool_present(c.flag, voice_);
      return true;
    case Verb::emulate_fault:
      fault(c.text.empty() ? Text("emulated fault") : c.text);
      return true;
    case Verb::hand_servo_cp:
      around_.held = true;
      around_.X_hand = base_frame_.inverse() * c.X;
      return true;
    case Verb::hand_servo_cf:
    case Verb::tool_servo_cf:
      around_.F = {base_frame_.R.transpose() * bounded(c.F.f), base_frame_.R.transpose() * bounded(c.F.t)};
      return true;
    case Verb::hand_gripper:
      pinch_ = std::clamp(c.value, 0.0, kGripperOpen);
      return true;
    case Verb::hand_free:
      around_ = {};
      pinch_ = kGripperOpen;
      return true;
    default:
      return false;
  }
}

}  // namespace palpate::dvrk
