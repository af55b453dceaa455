#include "dvrk/messages.hpp"

#include <array>
#include <cmath>
#include <limits>

namespace palpate::dvrk {
namespace {

constexpr unsigned kMtm = static_cast<unsigned>(ArmKind::mtm), kPsm = static_cast<unsigned>(ArmKind::psm),
                   kEcm = static_cast<unsigned>(ArmKind::ecm);

constexpr VerbEntry arm_verb(Verb verb, std::string_view name, Payload payload, unsigned arms = kEveryArm) {
  return {verb, Kind::arm, arms, name, payload};
}

constexpr std::array kVerbs{
    arm_verb(Verb::state_command, "state_command", Payload::text),
    arm_verb(Verb::servo_jp, "servo_jp", Payload::joints),
    arm_verb(Verb::servo_jr, "servo_jr", Payload::joints),
    arm_verb(Verb::servo_jf, "servo_jf", Payload::joints),
    arm_verb(Verb::servo_cp, "servo_cp", Payload::pose),
    arm_verb(Verb::servo_cr, "servo_cr", Payload::pose),
    arm_verb(Verb::servo_cs, "servo_cs", Payload::cartesian),
    arm_verb(Verb::servo_ci, "servo_ci", Payload::impedance),
    arm_verb(Verb::body_servo_cf, "body/servo_cf", Payload::wrench),
    arm_verb(Verb::spatial_servo_cf, "spatial/servo_cf", Payload::wrench),
    arm_verb(Verb::move_jp, "move_jp", Payload::joints),
    arm_verb(Verb::move_jr, "move_jr", Payload::joints),
    arm_verb(Verb::move_cp, "move_cp", Payload::pose),
    arm_verb(Verb::free, "free", Payload::none),
    arm_verb(Verb::hold, "hold", Payload::none),
    arm_verb(Verb::use_gravity_compensation, "use_gravity_compensation", Payload::flag),
    arm_verb(Verb::body_set_cf_orientation_absolute, "body/set_cf_orientation_absolute", Payload::flag),
    arm_verb(Verb::set_base_frame, "set_base_frame", Payload::pose),
    arm_verb(Verb::set_ratio, "trajectory_j/set_ratio", Payload::value),
    arm_verb(Verb::set_ratio_v, "trajectory_j/set_ratio_v", Payload::value),
    arm_verb(Verb::set_ratio_a, "trajectory_j/set_ratio_a", Payload::value),
    arm_verb(Verb::emulate_fault, "emulate_fault", Payload::text),
    arm_verb(Verb::lock_orientation, "lock_orientation", Payload::rotation, kMtm),
    arm_verb(Verb::unlock_orientation, "unlock_orientation", Payload::none, kMtm),
    arm_verb(Verb::hand_servo_cp, "hand/servo_cp", Payload::pose, kMtm),
    arm_verb(Verb::hand_servo_cf, "hand/servo_cf", Payload::wrench, kMtm),
    arm_verb(Verb::hand_gripper, "hand/gripper", Payload::value, kMtm),
    arm_verb(Verb::hand_free, "hand/free", Payload::none, kMtm),
    arm_verb(Verb::jaw_servo_jp, "jaw/servo_jp", Payload::joints, kPsm),
    arm_verb(Verb::jaw_move_jp, "jaw/move_jp", Payload::joints, kPsm),
    arm_verb(Verb::jaw_servo_jf, "jaw/servo_jf", Payload::joints, kPsm),
    arm_verb(Verb::set_tool_type, "set_tool_type", Payload::text, kPsm),
    arm_verb(Verb::emulate_adapter_present, "emulate_adapter_present", Payload::flag, kPsm),
    arm_verb(Verb::emulate_tool_present, "emulate_tool_present", Payload::flag, kPsm),
    arm_verb(Verb::tool_servo_cf, "tool/servo_cf", Payload::wrench, kPsm),
    arm_verb(Verb::emulate_arm_clutch, "emulate_arm_clutch", Payload::button, kPsm | kEcm),
    arm_verb(Verb::set_endoscope_type, "set_endoscope_type", Payload::text, kEcm),
    VerbEntry{Verb::power_on, Kind::system, 0, "power_on", Payload::none},
    VerbEntry{Verb::power_off, Kind::system, 0, "power_off", Payload::none},
    VerbEntry{Verb::home, Kind::system, 0, "home", Payload::none},
    VerbEntry{Verb::set_volume, Kind::system, 0, "set_volume", Payload::value},
    VerbEntry{Verb::beep, Kind::system, 0, "beep", Payload::numbers},
    VerbEntry{Verb::string_to_speech, Kind::system, 0, "string_to_speech", Payload::text},
    VerbEntry{Verb::teleop_enable, Kind::console, 0, "teleop/enable", Payload::flag},
    VerbEntry{Verb::teleop_select, Kind::console, 0, "teleop/select", Payload::text},
    VerbEntry{Verb::teleop_unselect, Kind::console, 0, "teleop/unselect", Payload::text},
    VerbEntry{Verb::teleop_set_scale, Kind::console, 0, "teleop/set_scale", Payload::value},
    VerbEntry{Verb::emulate_operator_present, Kind::console, 0, "emulate_operator_present", Payload::button},
    VerbEntry{Verb::emulate_clutch, Kind::console, 0, "emulate_clutch", Payload::button},
    VerbEntry{Verb::emulate_camera, Kind::console, 0, "emulate_camera", Payload::button},
    VerbEntry{Verb::press_clutch, Kind::footpedals, 0, "emulate_clutch", Payload::button},
    VerbEntry{Verb::press_camera, Kind::footpedals, 0, "emulate_camera", Payload::button},
    VerbEntry{Verb::press_coag, Kind::footpedals, 0, "emulate_coag", Payload::button},
    VerbEntry{Verb::press_bicoag, Kind::footpedals, 0, "emulate_bicoag", Payload::button},
    VerbEntry{Verb::press_cam_plus, Kind::footpedals, 0, "emulate_cam_plus", Payload::button},
    VerbEntry{Verb::press_cam_minus, Kind::footpedals, 0, "emulate_cam_minus", Payload::button},
    VerbEntry{Verb::teleop_state_command, Kind::teleop, 0, "state_command", Payload::text},
    VerbEntry{Verb::set_scale, Kind::teleop, 0, "set_scale", Payload::value},
    VerbEntry{Verb::lock_rotation, Kind::teleop, 0, "lock_rotation", Payload::flag},
    VerbEntry{Verb::lock_translation, Kind::teleop, 0, "lock_translation", Payload::flag},
    VerbEntry{Verb::set_align_MTM, Kind::teleop, 0, "set_align_MTM", Payload::flag},
    VerbEntry{Verb::following_mtm_body_servo_cf, Kind::teleop, 0, "following/mtm/body/servo_cf", Payload::wrench},
    VerbEntry{Verb::camera_state_command, Kind::camera_teleop, 0, "state_command", Payload::text},
    VerbEntry{Verb::camera_set_scale, Kind::camera_teleop, 0, "set_scale", Payload::value},
    VerbEntry{Verb::setup_state_command, Kind::setup, kPsm | kEcm, "state_command", Payload::text},
    VerbEntry{Verb::setup_servo_jp, Kind::setup, kPsm | kEcm, "servo_jp", Payload::joints},
    VerbEntry{Verb::setup_move_jp, Kind::setup, kPsm | kEcm, "move_jp", Payload::joints},
    VerbEntry{Verb::set_reference_arm, Kind::setup_cart, 0, "set_reference_arm", Payload::text},
    VerbEntry{Verb::focus_lock, Kind::focus, 0, "lock", Payload::flag},
    VerbEntry{Verb::focus_in, Kind::focus, 0, "focus_in", Payload::flag},
    VerbEntry{Verb::focus_out, Kind::focus, 0, "focus_out", Payload::flag},
};

constexpr TopicEntry arm_topic(Topic topic, std::string_view name, Payload payload, bool latched,
                               unsigned arms = kEveryArm) {
  return {topic, Kind::arm, arms, name, payload, latched};
}
constexpr TopicEntry words(Kind kind, Topic topic, std::string_view name) {
  return {topic, kind, kEveryArm, name, Payload::text, false};
}

constexpr std::array kTopics{
    arm_topic(Topic::operating_state, "operating_state", Payload::operating, true),
    arm_topic(Topic::desired_state, "desired_state", Payload::text, true),
    arm_topic(Topic::current_state, "current_state", Payload::text, true),
    arm_topic(Topic::goal_reached, "goal_reached", Payload::flag, false),
    arm_topic(Topic::ratio, "trajectory_j/ratio", Payload::value, true),
    arm_topic(Topic::ratio_v, "trajectory_j/ratio_v", Payload::value, true),
    arm_topic(Topic::ratio_a, "trajectory_j/ratio_a", Payload::value, true),
    arm_topic(Topic::gripper_closed, "gripper/closed", Payload::flag, true, kMtm),
    arm_topic(Topic::gripper_pinch, "gripper/pinch", Payload::none, false, kMtm),
    arm_topic(Topic::orientation_locked, "orientation_locked", Payload::flag, true, kMtm),
    arm_topic(Topic::tool_type, "tool_type", Payload::text, true, kPsm),
    arm_topic(Topic::tool_type_request, "tool_type_request", Payload::none, false, kPsm),
    arm_topic(Topic::arm_clutch, "arm_clutch", Payload::button, false, kPsm | kEcm),
    arm_topic(Topic::endoscope_type, "endoscope_type", Payload::text, true, kEcm),
    words(Kind::arm, Topic::status, "status"),
    words(Kind::arm, Topic::warning, "warning"),
    words(Kind::arm, Topic::error, "error"),
    words(Kind::system, Topic::status, "status"),
    words(Kind::system, Topic::warning, "warning"),
    words(Kind::system, Topic::error, "error"),
    TopicEntry{Topic::volume, Kind::system, 0, "volume", Payload::value, true},
    words(Kind::console, Topic::status, "status"),
    words(Kind::console, Topic::warning, "warning"),
    words(Kind::console, Topic::error, "error"),
    TopicEntry{Topic::teleop_enabled, Kind::console, 0, "teleop/enabled", Payload::flag, true},
    TopicEntry{Topic::teleop_selected, Kind::console, 0, "teleop/selected", Payload::text, true},
    TopicEntry{Topic::teleop_unselected, Kind::console, 0, "teleop/unselected", Payload::text, true},
    TopicEntry{Topic::teleop_scale, Kind::console, 0, "teleop/scale", Payload::value, true},
    TopicEntry{Topic::operator_present, Kind::console, 0, "operator_present", Payload::button, true},
    TopicEntry{Topic::clutch, Kind::console, 0, "clutch", Payload::button, true},
    TopicEntry{Topic::camera, Kind::console, 0, "camera", Payload::button, true},
    TopicEntry{Topic::pedal_clutch, Kind::footpedals, 0, "clutch", Payload::button, true},
    TopicEntry{Topic::pedal_camera, Kind::footpedals, 0, "camera", Payload::button, true},
    TopicEntry{Topic::pedal_coag, Kind::footpedals, 0, "coag", Payload::button, true},
    TopicEntry{Topic::pedal_bicoag, Kind::footpedals, 0, "bicoag", Payload::button, true},
    TopicEntry{Topic::pedal_cam_plus, Kind::footpedals, 0, "cam_plus", Payload::button, true},
    TopicEntry{Topic::pedal_cam_minus, Kind::footpedals, 0, "cam_minus", Payload::button, true},
    TopicEntry{Topic::teleop_desired_state, Kind::teleop, 0, "desired_state", Payload::text, true},
    TopicEntry{Topic::teleop_current_state, Kind::teleop, 0, "current_state", Payload::text, true},
    TopicEntry{Topic::following, Kind::teleop, 0, "following", Payload::flag, true},
    TopicEntry{Topic::scale, Kind::teleop, 0, "scale", Payload::value, true},
    TopicEntry{Topic::rotation_locked, Kind::teleop, 0, "rotation_locked", Payload::button, true},
    TopicEntry{Topic::translation_locked, Kind::teleop, 0, "translation_locked", Payload::button, true},
    TopicEntry{Topic::align_MTM, Kind::teleop, 0, "align_mtm", Payload::flag, true},
    words(Kind::teleop, Topic::status, "status"),
    words(Kind::teleop, Topic::warning, "warning"),
    words(Kind::teleop, Topic::error, "error"),
    TopicEntry{Topic::teleop_desired_state, Kind::camera_teleop, 0, "desired_state", Payload::text, true},
    TopicEntry{Topic::teleop_current_state, Kind::camera_teleop, 0, "current_state", Payload::text, true},
    TopicEntry{Topic::following, Kind::camera_teleop, 0, "following", Payload::flag, true},
    TopicEntry{Topic::scale, Kind::camera_teleop, 0, "scale", Payload::value, true},
    words(Kind::camera_teleop, Topic::status, "status"),
    words(Kind::camera_teleop, Topic::warning, "warning"),
    words(Kind::camera_teleop, Topic::error, "error"),
    TopicEntry{Topic::operating_state, Kind::setup, kPsm | kEcm, "operating_state", Payload::operating, true},
    TopicEntry{Topic::status, Kind::setup, kPsm | kEcm, "status", Payload::text, false},
    TopicEntry{Topic::warning, Kind::setup, kPsm | kEcm, "warning", Payload::text, false},
    TopicEntry{Topic::error, Kind::setup, kPsm | kEcm, "error", Payload::text, false},
    TopicEntry{Topic::locked, Kind::focus, 0, "locked", Payload::flag, true},
    TopicEntry{Topic::focusing_in, Kind::focus, 0, "focusing_in", Payload::flag, true},
    TopicEntry{Topic::focusing_out, Kind::focus, 0, "focusing_out", Payload::flag, true},
};

}  // namespace

bool is_rotation(const Mat3& R) noexcept {
  return R.allFinite() && (R * R.transpose() - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-3 && R.determinant() > 0.0;
}

bool is_pose(const Pose& X) noexcept {
  constexpr double kFarthest = 100.0;  // [m]
  return is_rotation(X.R) && X.p.allFinite() && X.p.cwiseAbs().maxCoeff() < kFarthest;
}

std::span<const VerbEntry> verbs() noexcept { return kVerbs; }
std::span<const TopicEntry> topics() noexcept { return kTopics; }

std::string_view name_of(State state) noexcept {
  constexpr std::array<std::string_view, 4> kNames{"DISABLED", "ENABLED", "PAUSED", "FAULT"};
  return kNames[static_cast<std::size_t>(state)];
}

JointVector joints(std::span<const double> numbers) noexcept {
  const auto n = static_cast<Eigen::Index>(std::min<std::size_t>(numbers.size(), kMaxJoints));
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), n);
}

Mat3 rotation(double x, double y, double z, double w) noexcept {
  const double norm = std::sqrt(x * x + y * y + z * z + w * w);
  if (!std::isfinite(norm) || norm < 1e-6) return Mat3::Constant(std::numeric_limits<double>::quiet_NaN());
  return Eigen::Quaterniond(w / norm, x / norm, y / norm, z / norm).toRotationMatrix();
}

}  // namespace palpate::dvrk
