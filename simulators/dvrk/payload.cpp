#include "dvrk/payload.hpp"

#include <cmath>

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

/// n: number of joints that the command applies to.
bool is_usable(const Command& c, Payload payload, Eigen::Index n) noexcept {
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

}  // namespace

Text payload_refusal(const Command& c, const VerbEntry& verb, Eigen::Index n) noexcept {
  const Eigen::Index joints = is_jaw(c.verb) ? 1 : n;
  if (is_usable(c, verb.payload, joints)) return {};
  Text words(verb.name);
  words << " refused: ";
  if (verb.payload == Payload::joints) {
    words << "it needs " << static_cast<long>(joints) << " finite numbers, one per joint";
  } else {
    words << "it needs finite numbers, and rotations that are rotations";
  }
  return words;
}

}  // namespace palpate::dvrk
