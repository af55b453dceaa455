// States and events of the simulated dVRK as Python values; the keys are the names of the topics.
#include <nanobind/stl/string.h>

#include "convert.hpp"
#include "dvrk/bindings.hpp"

namespace nb = nanobind;

namespace palpate::bindings {
namespace {

std::string text_of(const dvrk::Text& text) { return std::string(text.view()); }

Vec6 six(const Twist& V) {
  Vec6 six;
  six << V.v, V.w;
  return six;
}

nb::object event_value(const dvrk::Event& e, dvrk::Payload payload) {
  switch (payload) {
    case dvrk::Payload::flag:
      return nb::cast(e.flag);
    case dvrk::Payload::value:
      return nb::cast(e.value);
    case dvrk::Payload::button:
      return nb::cast(e.button);
    case dvrk::Payload::text:
      return nb::cast(text_of(e.text));
    case dvrk::Payload::operating:
      return nb::make_tuple(std::string(dvrk::name_of(e.operating_state.state)), e.operating_state.is_homed,
                            e.operating_state.is_busy);
    default:
      return nb::none();
  }
}

}  // namespace

Fields joint_state(const dvrk::JointState& js) {
  Fields d;
  d["position"] = Eigen::VectorXd(js.q);
  d["velocity"] = Eigen::VectorXd(js.v);
  d["effort"] = Eigen::VectorXd(js.tau);
  return d;
}

Fields arm_state(const dvrk::ArmState& s) {
  Fields d;
  d["t"] = s.t;
  d["state"] = std::string(dvrk::name_of(s.operating_state.state));
  d["is_homed"] = s.operating_state.is_homed;
  d["is_busy"] = s.operating_state.is_busy;
  d["joints_valid"] = s.joints_valid;
  d["cartesian_valid"] = s.cartesian_valid;
  d["measured_js"] = joint_state(s.measured_js);
  d["setpoint_js"] = joint_state(s.setpoint_js);
  d["gravity_compensation/setpoint_js"] = Eigen::VectorXd(s.gravity_compensation);
  d["measured_cp"] = to_matrix(s.measured_cp);
  d["setpoint_cp"] = to_matrix(s.setpoint_cp);
  d["local/measured_cp"] = to_matrix(s.local_measured_cp);
  d["local/setpoint_cp"] = to_matrix(s.local_setpoint_cp);
  d["measured_cv"] = six(s.measured_cv);
  d["setpoint_cv"] = six(s.setpoint_cv);
  d["local/measured_cv"] = six(s.local_measured_cv);
  d["local/setpoint_cv"] = six(s.local_setpoint_cv);
  d["measured_cf"] = to_vector(s.measured_cf);
  d["body/measured_cf"] = to_vector(s.body_measured_cf);
  d["spatial/measured_cf"] = to_vector(s.spatial_measured_cf);
  d["body/jacobian"] = Eigen::MatrixXd(s.body_jacobian);
  d["spatial/jacobian"] = Eigen::MatrixXd(s.spatial_jacobian);
  d["orientation_locked"] = s.orientation_locked;
  d["gripper"] = s.gripper.q[0];
  d["jaw_valid"] = s.jaw_valid;
  d["jaw/measured_js"] = joint_state(s.jaw_measured_js);
  d["jaw/setpoint_js"] = joint_state(s.jaw_setpoint_js);
  d["F_hand"] = to_vector(s.F_hand);
  if (s.setup_js.q.size() > 0) {
    d["SUJ/measured_js"] = joint_state(s.setup_js);
    d["SUJ/measured_cp"] = to_matrix(s.setup_cp);
    d["SUJ/local/measured_cp"] = to_matrix(s.local_setup_cp);
  }
  d["reference"] = std::string(s.reference);
  return d;
}

Fields teleop_state(const dvrk::TeleopState& s) {
  Fields d;
  d["current_state"] = text_of(s.current_state);
  d["desired_state"] = text_of(s.desired_state);
  d["following"] = s.following;
  d["scale"] = s.scale;
  d["alignment_offset"] = Eigen::Matrix3d(s.alignment_offset);
  return d;
}

Events events(dvrk::System& system) {
  Events list;
  dvrk::Event e;
  while (system.next(e)) {
    for (const dvrk::TopicEntry& entry : dvrk::topics()) {
      if (entry.topic != e.topic || entry.kind != e.from.kind) continue;
      list.append(
          nb::make_tuple(e.t, system.component_name(e.from), std::string(entry.name), event_value(e, entry.payload)));
      break;
    }
  }
  return list;
}

}  // namespace palpate::bindings
