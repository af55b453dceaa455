// The simulated dVRK, by the names of its topics. Payloads go in as they are: refusing them is the component's
// business.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/dvrk/impedance.hpp"
#include "palpate/dvrk/system.hpp"
#include "palpate/dvrk/trajectory.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using dvrk::ArmKind;
using dvrk::ArmSpec;
using dvrk::Command;
using dvrk::Kind;
using dvrk::Payload;
using dvrk::System;
using dvrk::SystemSpec;
using dvrk::TeleopSpec;
using Vector = Eigen::VectorXd;

std::string text_of(const dvrk::Text& text) { return std::string(text.view()); }

Vec6 six(const Twist& V) {
  Vec6 six;
  six << V.v, V.w;
  return six;
}

// ---- names

dvrk::Address address(const System& system, const std::string& component) {
  if (component == "system") return {Kind::system, 0};
  if (component == "console") return {Kind::console, 0};
  if (component == "footpedals") return {Kind::footpedals, 0};
  for (std::size_t k = 0; k < system.arms().size(); ++k) {
    if (system.arms()[k] == component) return {Kind::arm, static_cast<int>(k)};
  }
  for (std::size_t k = 0; k < system.teleops().size(); ++k) {
    if (system.teleops()[k] == component) return {Kind::teleop, static_cast<int>(k)};
  }
  std::string names = "system, console, footpedals";
  for (const auto& list : {system.arms(), system.teleops()}) {
    for (const auto& name : list) names += ", " + name;
  }
  throw std::invalid_argument("the simulated dVRK has no component '" + component + "'; there are " + names);
}

int arm_index(const System& system, const std::string& name) {
  const dvrk::Address at = address(system, name);
  if (at.kind != Kind::arm) throw std::invalid_argument("'" + name + "' is not an arm of the simulated dVRK");
  return at.index;
}

std::string name_of(const System& system, const dvrk::Address& at) {
  switch (at.kind) {
    case Kind::system:
      return "system";
    case Kind::console:
      return "console";
    case Kind::footpedals:
      return "footpedals";
    case Kind::arm:
      return system.arms()[static_cast<std::size_t>(at.index)];
    case Kind::teleop:
      return system.teleops()[static_cast<std::size_t>(at.index)];
  }
  return {};
}

const dvrk::VerbEntry& verb_entry(const System& system, const dvrk::Address& at, const std::string& name) {
  for (const dvrk::VerbEntry& entry : dvrk::verbs()) {
    const bool knows = at.kind != Kind::arm || (entry.arms & static_cast<unsigned>(system.kind(at.index))) != 0;
    if (entry.kind == at.kind && entry.name == name && knows) return entry;
  }
  throw std::invalid_argument(name_of(system, at) + " has no command '" + name + "' (dvrk_verbs() lists them)");
}

// ---- commands in

JointVector numbers(const nb::object& value) {
  const Vector all = nb::cast<VectorArg>(value).values;
  return dvrk::joints({all.data(), static_cast<std::size_t>(all.size())});
}

/// The numbers of a square matrix (n, n), row by row.
Vector square(const nb::object& value, Eigen::Index n) {
  const auto all = nb::cast<VectorArg>(nb::module_::import_("numpy").attr("ravel")(value)).values;
  if (all.size() != n * n) {
    const std::string shape = "(" + std::to_string(n) + ", " + std::to_string(n) + ")";
    throw std::invalid_argument("a matrix " + shape + " is needed; got " + std::to_string(all.size()) + " numbers");
  }
  return all;
}

Mat3 raw_rotation(const nb::object& value) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(square(value, 3).data());
}

Pose raw_pose(const nb::object& value) {
  const Vector all = square(value, 4);
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> X(all.data());
  return {X.topLeftCorner<3, 3>(), X.topRightCorner<3, 1>()};
}

Wrench raw_wrench(const nb::object& value) { return wrench(nb::cast<VectorArg>(value).values, "wrench"); }

dvrk::HalfPlane half_plane(const nb::dict& gains, const char* side) {
  dvrk::HalfPlane h;
  if (!gains.contains(side)) return h;
  const auto given = nb::cast<nb::dict>(gains[side]);
  const auto read = [&](const char* name, Vec3& out) {
    if (given.contains(name)) out = nb::cast<VectorArg>(given[name]).values.head<3>();
  };
  read("p", h.p);
  read("d", h.d);
  read("bias", h.bias);
  read("deadband", h.deadband);
  return h;
}

dvrk::Impedance impedance(const nb::dict& goal) {
  dvrk::Impedance i;
  if (goal.contains("force_orientation")) i.R_force = raw_rotation(nb::object(goal["force_orientation"]));
  if (goal.contains("force_position")) i.p_force = nb::cast<VectorArg>(goal["force_position"]).values.head<3>();
  if (goal.contains("torque_orientation")) i.R_torque = raw_rotation(nb::object(goal["torque_orientation"]));
  i.position_positive = half_plane(goal, "position_positive");
  i.position_negative = half_plane(goal, "position_negative");
  i.orientation_positive = half_plane(goal, "orientation_positive");
  i.orientation_negative = half_plane(goal, "orientation_negative");
  return i;
}

void fill(Command& c, const dvrk::VerbEntry& entry, const nb::object& value, const nb::object& velocity) {
  switch (entry.payload) {
    case Payload::none:
      break;
    case Payload::flag:
      c.flag = nb::cast<bool>(value);
      break;
    case Payload::value:
      c.value = nb::cast<double>(value);
      break;
    case Payload::text:
      c.text = std::string_view(nb::cast<std::string>(value));
      break;
    case Payload::button:
      c.button = nb::cast<int>(value);
      break;
    case Payload::numbers:
      c.position = numbers(value);
      break;
    case Payload::joints:
      (entry.name.ends_with("jf") ? c.effort : c.position) = numbers(value);
      if (!velocity.is_none()) c.velocity = numbers(velocity);
      break;
    case Payload::pose:
      c.X = raw_pose(value);
      break;
    case Payload::rotation:
      c.X.R = raw_rotation(value);
      break;
    case Payload::wrench:
      c.F = raw_wrench(value);
      break;
    case Payload::impedance:
      c.impedance = impedance(nb::cast<nb::dict>(value));
      break;
    case Payload::cartesian: {
      const auto parts = nb::cast<nb::dict>(value);
      c.pose_is_valid = parts.contains("pose");
      c.twist_is_valid = parts.contains("twist");
      c.wrench_is_valid = parts.contains("wrench");
      if (c.pose_is_valid) c.X = raw_pose(parts["pose"]);
      if (c.wrench_is_valid) c.F = raw_wrench(parts["wrench"]);
      if (c.twist_is_valid) {
        const Wrench V = raw_wrench(parts["twist"]);
        c.V = {V.f, V.t};
      }
      break;
    }
    case Payload::operating:
      break;
  }
}

// ---- states and events out

nb::dict joint_state(const dvrk::JointState& js) {
  nb::dict d;
  d["position"] = Vector(js.q);
  d["velocity"] = Vector(js.v);
  d["effort"] = Vector(js.tau);
  return d;
}

nb::dict arm_state(const dvrk::ArmState& s) {
  nb::dict d;
  d["t"] = s.t;
  d["state"] = std::string(dvrk::name_of(s.operating_state.state));
  d["is_homed"] = s.operating_state.is_homed;
  d["is_busy"] = s.operating_state.is_busy;
  d["joints_valid"] = s.joints_valid;
  d["cartesian_valid"] = s.cartesian_valid;
  d["measured_js"] = joint_state(s.measured_js);
  d["setpoint_js"] = joint_state(s.setpoint_js);
  d["gravity_compensation/setpoint_js"] = Vector(s.gravity_compensation);
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
  return d;
}

nb::object event_value(const dvrk::Event& e, Payload payload) {
  switch (payload) {
    case Payload::flag:
      return nb::cast(e.flag);
    case Payload::value:
      return nb::cast(e.value);
    case Payload::button:
      return nb::cast(e.button);
    case Payload::text:
      return nb::cast(text_of(e.text));
    case Payload::operating:
      return nb::make_tuple(std::string(dvrk::name_of(e.operating_state.state)), e.operating_state.is_homed,
                            e.operating_state.is_busy);
    default:
      return nb::none();
  }
}

nb::list events(System& system) {
  nb::list list;
  dvrk::Event e;
  while (system.next(e)) {
    for (const dvrk::TopicEntry& entry : dvrk::topics()) {
      if (entry.topic != e.topic || entry.kind != e.from.kind) continue;
      list.append(nb::make_tuple(e.t, name_of(system, e.from), std::string(entry.name), event_value(e, entry.payload)));
      break;
    }
  }
  return list;
}

void bind_spec(nb::module_& m) {
  nb::class_<ArmSpec> spec(m, "DvrkArmSpec",
                           "What an arm of the simulated dVRK is built from (palpate.dvrk fills it).");
  spec.def(
          "__init__",
          [](ArmSpec* self, const std::string& name, const std::string& kind, const arm::Arm& model) {
            if (kind != "mtm" && kind != "psm" && kind != "ecm") {
              throw std::invalid_argument("a dVRK arm is an mtm, a psm or an ecm; got '" + kind + "'");
            }
            const ArmKind k = kind == "mtm" ? ArmKind::mtm : kind == "psm" ? ArmKind::psm : ArmKind::ecm;
            new (self) ArmSpec{name, k, model};
          },
          "name"_a, "kind"_a, "model"_a)
      .def_ro("name", &ArmSpec::name)
      .def_rw("dynamic", &ArmSpec::dynamic, "moved by torques, or servoed joints that no torque moves")
      .def_rw("leader", &ArmSpec::leader, "drives, friction, encoders of a dynamic arm")
      .def_rw("follower", &ArmSpec::follower, "joint servos of the other")
      .def_rw("hand", &ArmSpec::hand, "of whoever holds an MTM")
      .def_rw("has_gravity_model", &ArmSpec::has_gravity_model)
      .def_rw("platform_gain", &ArmSpec::platform_gain, "of an MTM's joint 4, 0..1")
      .def_prop_rw(
          "base_frame", [](const ArmSpec& s) { return to_matrix(s.base_frame); },
          [](ArmSpec& s, const Matrix4& X) { s.base_frame = to_pose(X, "base_frame"); }, "(4,4)")
      .def_rw("cannula_link", &ArmSpec::cannula_link, "link that must be past the cannula; -1: none")
      .def_rw("jaw_min", &ArmSpec::jaw_min, "[rad]")
      .def_rw("jaw_max", &ArmSpec::jaw_max, "[rad]")
      .def_rw("jaw_v_max", &ArmSpec::jaw_v_max, "[rad/s]")
      .def_rw("jaw_a_max", &ArmSpec::jaw_a_max, "[rad/s^2]")
      .def_rw("tool_type", &ArmSpec::tool_type, "what is mounted at first; empty: nothing")
      .def_rw("power_time", &ArmSpec::power_time, "[s]")
      .def_rw("bias_time", &ArmSpec::bias_time, "[s]");
  joint_field(spec, "P", &ArmSpec::P, "(n,) position control [N m/rad, N/m]");
  joint_field(spec, "D", &ArmSpec::D, "(n,) position control [N m s/rad, N s/m]");
  joint_field(spec, "tracking_error", &ArmSpec::tracking_error, "(n,) beyond it: fault [rad, m]");
  joint_field(spec, "v_max", &ArmSpec::v_max, "(n,) of trajectories [rad/s, m/s]");
  joint_field(spec, "a_max", &ArmSpec::a_max, "(n,) of trajectories [rad/s^2, m/s^2]");
  joint_field(spec, "start", &ArmSpec::start, "(n,) joints at power-up");
  joint_field(spec, "home", &ArmSpec::home, "(n,) joints after homing");

  nb::class_<TeleopSpec>(m, "DvrkTeleopSpec", "MTM and PSM, by index among the arms.")
      .def(nb::init<>())
      .def_rw("mtm", &TeleopSpec::mtm)
      .def_rw("psm", &TeleopSpec::psm)
      .def_rw("scale", &TeleopSpec::scale)
      .def_rw("align_MTM", &TeleopSpec::align_MTM)
      .def_rw("rotation_locked", &TeleopSpec::rotation_locked)
      .def_rw("translation_locked", &TeleopSpec::translation_locked)
      .def_rw("orientation_tolerance", &TeleopSpec::orientation_tolerance, "[rad]")
      .def_rw("gripper_threshold", &TeleopSpec::gripper_threshold, "[rad]")
      .def_rw("roll_threshold", &TeleopSpec::roll_threshold, "[rad]")
      .def_rw("jaw_rate", &TeleopSpec::jaw_rate, "[rad/s]")
      .def_rw("jaw_rate_after_clutch", &TeleopSpec::jaw_rate_after_clutch, "[rad/s]");
}

void bind_system(nb::module_& m) {
  nb::class_<System>(m, "DvrkSystem", "The simulated dVRK (palpate.dvrk.system makes one).")
      .def(
          "__init__",
          [](System* self, const std::vector<ArmSpec>& arms, const std::vector<TeleopSpec>& teleops,
             const std::vector<int>& camera) {
            SystemSpec spec;
            spec.arms = arms;
            spec.teleops = teleops;
            if (camera.size() == 3) {
              spec.camera_mtml = camera[0];
              spec.camera_mtmr = camera[1];
              spec.camera_ecm = camera[2];
            }
            new (self) System(std::move(spec));
          },
          "arms"_a, "teleops"_a, "camera"_a = std::vector<int>{},
          "camera: indices of MTML, MTMR and ECM that the camera pedal couples, or none.")
      .def_prop_ro("arms", &System::arms)
      .def_prop_ro("teleops", &System::teleops)
      .def_prop_ro("t", &System::t, "[s]")
      .def_prop_ro_static(
          "tick", [](nb::handle) { return System::kTick; }, "[s]")
      .def_prop_ro("dropped_events", &System::dropped_events)
      .def(
          "step",
          [](System& s, int n) {
            for (int k = 0; k < n; ++k) s.step();
          },
          "n"_a = 1, nb::call_guard<nb::gil_scoped_release>(), "n ticks of 1/3 ms.")
      .def(
          "send",
          [](System& s, const std::string& component, const std::string& verb, const nb::object& value,
             const nb::object& velocity) {
            Command c;
            c.to = address(s, component);
            const dvrk::VerbEntry& entry = verb_entry(s, c.to, verb);
            c.verb = entry.verb;
            fill(c, entry, value, velocity);
            return s.apply(c);
          },
          "component"_a, "verb"_a, "value"_a = nb::none(), "velocity"_a = nb::none(),
          "A command by the name of its topic. The value as its payload wants it: bool, float, str, int (button), "
          "joints\n"
          "(n,), pose (4,4), rotation (3,3), wrench (6,), {pose, twist, wrench} or the gains of servo_ci as a dict.")
      .def("events", &events, "What has happened since the last call: [(t, component, topic, value), ..].")
      .def(
          "state", [](const System& s, const std::string& arm) { return arm_state(s.arm(arm_index(s, arm))); }, "arm"_a,
          "What an arm publishes, by the names of its topics.")
      .def(
          "truth", [](const System& s, const std::string& arm) { return joint_state(s.truth(arm_index(s, arm))); },
          "arm"_a, "True joints of a simulated arm, for judges.")
      .def(
          "teleop",
          [](const System& s, const std::string& name) {
            const dvrk::Address at = address(s, name);
            if (at.kind != Kind::teleop) throw std::invalid_argument("'" + name + "' is not a teleop");
            const dvrk::TeleopState& state = s.teleop(at.index);
            nb::dict d;
            d["current_state"] = text_of(state.current_state);
            d["desired_state"] = text_of(state.desired_state);
            d["following"] = state.following;
            d["scale"] = state.scale;
            d["alignment_offset"] = Eigen::Matrix3d(state.alignment_offset);
            return d;
          },
          "name"_a)
      .def(
          "forward_kinematics",
          [](System& s, const std::string& arm, const VectorArg& q) -> nb::object {
            Pose X;
            const JointVector joints = dvrk::joints({q.values.data(), static_cast<std::size_t>(q.values.size())});
            if (!s.forward_kinematics(arm_index(s, arm), joints, X)) return nb::none();
            return nb::cast(to_matrix(X));
          },
          "arm"_a, "q"_a)
      .def(
          "inverse_kinematics",
          [](System& s, const std::string& arm, const nb::object& X, const VectorArg& q) -> nb::object {
            JointVector joints = dvrk::joints({q.values.data(), static_cast<std::size_t>(q.values.size())});
            if (!s.inverse_kinematics(arm_index(s, arm), raw_pose(X), joints)) return nb::none();
            return nb::cast(Vector(joints));
          },
          "arm"_a, "X"_a, "q"_a)
      .def(
          "joint_position",
          [](System& s, const std::string& arm, const VectorArg& actuators) -> nb::object {
            const JointVector q = s.joint_position(
                arm_index(s, arm),
                dvrk::joints({actuators.values.data(), static_cast<std::size_t>(actuators.values.size())}));
            return q.size() == 0 ? nb::none() : nb::cast(Vector(q));
          },
          "arm"_a, "actuators"_a);
}

void bind_pieces(nb::module_& m) {
  m.def(
      "dvrk_verbs",
      [] {
        nb::list list;
        for (const dvrk::VerbEntry& e : dvrk::verbs()) {
          list.append(
              nb::make_tuple(static_cast<int>(e.kind), e.arms, std::string(e.name), static_cast<int>(e.payload)));
        }
        return list;
      },
      "Every command: (kind of component, arms as bits, name, payload).");
  m.def(
      "dvrk_topics",
      [] {
        nb::list list;
        for (const dvrk::TopicEntry& e : dvrk::topics()) {
          list.append(nb::make_tuple(static_cast<int>(e.kind), e.arms, std::string(e.name), static_cast<int>(e.payload),
                                     e.latched));
        }
        return list;
      },
      "Every event: (kind of component, arms as bits, name, payload, latched).");
  m.def(
      "dvrk_impedance",
      [](const nb::dict& goal, const Matrix4& X, const Vec6& V) {
        return to_vector(dvrk::impedance_wrench(impedance(goal), to_pose(X, "X"), {V.head<3>(), V.tail<3>()}));
      },
      "goal"_a, "X"_a, "V"_a, "Wrench of servo_ci (6,) at a pose with a velocity, all in the base frame.");
  nb::class_<dvrk::Trajectory>(m, "DvrkTrajectory", "Joints that start and come to rest together, within v and a.")
      .def(nb::init<>())
      .def(
          "start",
          [](dvrk::Trajectory& t, const Vector& q, const Vector& v, const Vector& goal, const Vector& v_max,
             const Vector& a_max) {
            const Eigen::Index n = q.size();
            t.start(joint_vector(q, "q"), joint_vector(v, "v", n), joint_vector(goal, "goal", n),
                    joint_vector(v_max, "v_max", n), joint_vector(a_max, "a_max", n));
          },
          "q"_a, "v"_a, "goal"_a, "v_max"_a, "a_max"_a)
      .def("step", &dvrk::Trajectory::step, "dt"_a)
      .def_prop_ro("q", [](const dvrk::Trajectory& t) -> Vector { return t.q(); })
      .def_prop_ro("v", [](const dvrk::Trajectory& t) -> Vector { return t.v(); })
      .def_prop_ro("done", &dvrk::Trajectory::done)
      .def_prop_ro("duration", &dvrk::Trajectory::duration, "[s]");
}

}  // namespace

void bind_dvrk(nb::module_& m) {
  bind_spec(m);
  bind_system(m);
  bind_pieces(m);
}

}  // namespace palpate::bindings
