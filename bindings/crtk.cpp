#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <optional>
#include <utility>

#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
#include "palpate/loop/crtk_cycle.hpp"
#include "palpate/loop/cycle.hpp"
#include "rows.hpp"
#include "types.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using loop::CrtkCycle;
using loop::CrtkGates;
using loop::CrtkOptions;
using loop::WatchOptions;

/// The options that a joint-level cycle and a CRTK cycle have in common; all others keep their defaults.
CrtkOptions from_cycle(const loop::CycleOptions& o, const Eigen::VectorXd& q_follower0) {
  CrtkOptions c;
  static_cast<loop::HapticsOptions&>(c) = o;
  c.X_WB = o.X_WB;
  c.q_follower0 = joint_vector(q_follower0, "q_follower0");
  c.watch.stale_after = o.stability.stale_after;
  return c;
}

void bind_crtk_options(nb::module_& m) {
  nb::class_<WatchOptions>(m, "WatchOptions", "Limits within which a stream of stamped messages is trusted.")
      .def(nb::init<>())
      .def_rw("stale_after", &WatchOptions::stale_after,
              "Silence, age of a message or clock jump that counts as a fault [s]."_doc)
      .def_rw("v_max", &WatchOptions::v_max, "Largest plausible speed [m/s]."_doc)
      .def_rw("w_max", &WatchOptions::w_max, "Largest plausible angular speed [rad/s]."_doc)
      .def_rw("p_slack", &WatchOptions::p_slack, "Displacement allowed in addition, for jitter of the stamps [m]."_doc)
      .def_rw("R_slack", &WatchOptions::R_slack, "Rotation allowed in addition, for jitter of the stamps [rad]."_doc);

  nb::class_<CrtkOptions>(m, "CrtkOptions",
                          "Options of the haptic cycle for devices that exchange poses and wrenches (CRTK).")
      .def(nb::new_(&from_cycle), "cycle"_a, "q_follower0"_a = Eigen::VectorXd(),
           "Takes the common options from a joint-level cycle. X_WL and X_WB are the poses in W of the frames of "
           "measured_cp. q_follower0: initial joint positions of a virtual follower [rad, m].")
      .def_prop_ro(
          "rate", [](const CrtkOptions& o) { return o.rate; }, "Rate of the haptic cycle [Hz].")
      .def_prop_rw(
          "stability", [](const CrtkOptions& o) { return o.stability; },
          [](CrtkOptions& o, const stability::Options& s) { o.stability = s; },
          "Options of the stage `stability`. This is a copy: assign it whole.")
      .def_rw("own_teleop", &CrtkOptions::own_teleop,
              "True: this cycle teleoperates the follower; False: another program does."_doc)
      .def_rw("virtual_follower", &CrtkOptions::virtual_follower,
              "True: no follower exists, and the tool is at the mapped goal."_doc)
      .def_rw("tip_frame", &CrtkOptions::tip_frame,
              "True: the leader takes wrenches in its tip frame; False: in the frame of measured_cp."_doc)
      .def_rw("needs_operator", &CrtkOptions::needs_operator,
              "True: teleoperation by this cycle requires an operator at the console."_doc)
      .def_rw("needs_state", &CrtkOptions::needs_state, "True: the arms must have reported their operating states."_doc)
      .def_rw("watch", &CrtkOptions::watch, "Limits for the incoming messages."_doc)
      .def_rw("release", &CrtkOptions::release, "Time from a fault or a pedal event to zero force [s]."_doc)
      .def_rw("settle", &CrtkOptions::settle, "Time without faults after which the force returns [s]."_doc)
      .def_rw("lag_most", &CrtkOptions::max_lag, "Largest distance of the follower from its goal [m]."_doc)
      .def_rw("slowest", &CrtkOptions::max_period_ratio,
              "Largest mean interval between two states of the leader [periods of the cycle]."_doc);

  nb::class_<CrtkGates>(m, "CrtkGates", "States reported by the console and the arms; False until reported.")
      .def(nb::init<>())
      .def_rw("following", &CrtkGates::following, "The teleoperation is active."_doc)
      .def_rw("operator_present", &CrtkGates::operator_present, "An operator is at the console."_doc)
      .def_rw("clutch", &CrtkGates::clutch, "The clutch pedal is pressed."_doc)
      .def_rw("camera", &CrtkGates::camera, "The camera pedal is pressed."_doc)
      .def_rw("leader_enabled", &CrtkGates::leader_enabled, "The leader is enabled and homed."_doc)
      .def_rw("follower_enabled", &CrtkGates::follower_enabled, "The follower is enabled and homed."_doc)
      .def_rw("second_writer", &CrtkGates::second_writer, "Another program publishes wrenches to the leader."_doc)
      .def_rw("other_teleop", &CrtkGates::other_teleop,
              "Another teleoperation is active although own_teleop is set."_doc)
      .def_rw("frame_unsure", &CrtkGates::frame_unsure,
              "The leader may take wrenches in another frame, or does not compensate its own weight."_doc)
      .def_rw("guarded", &CrtkGates::guarded, "The guardian has latched or is missing."_doc)
      .def_rw("two_sources", &CrtkGates::two_sources, "Several nodes publish one of the inputs."_doc)
      .def_rw("no_listener", &CrtkGates::no_listener, "Nobody receives the wrenches."_doc)
      .def_rw("base_moved", &CrtkGates::base_moved, "An arm reports its pose in another frame than at the start."_doc);
}

Tuple<Array, std::optional<Vec6>, std::optional<Matrix4>, double> step(CrtkCycle& self, double t, double wall) {
  const loop::CrtkOutput& out = self.step({t, wall});
  const auto goal = out.move ? std::optional(to_matrix(out.X_BT_goal)) : std::nullopt;
  return nb::make_tuple(to_row(out.tick), out.command ? std::optional<Vec6>(to_vector(out.F)) : std::nullopt, goal,
                        out.jaw);
}

void bind_messages(nb::class_<CrtkCycle>& cycle) {
  cycle
      .def(
          "leader_pose",
          [](CrtkCycle& self, double stamp, const Vec3& p, const Eigen::Vector4d& quat, double t, double wall) {
            self.leader_pose(stamp, p, quat, {t, wall});
          },
          "stamp"_a, "p_LH"_a, "quat_xyzw"_a, "t"_a, "wall"_a, "Receives measured_cp of the leader [m].")
      .def(
          "leader_twist",
          [](CrtkCycle& self, double stamp, const Vec3& v, const Vec3& w, double t, double wall) {
            self.leader_twist(stamp, {v, w}, {t, wall});
          },
          "stamp"_a, "v_LH"_a, "w_LH"_a, "t"_a, "wall"_a, "Receives measured_cv of the leader [m/s, rad/s].")
      .def(
          "leader_joints",
          [](CrtkCycle& self, double stamp, const Eigen::VectorXd& q) {
            self.leader_joints(stamp, q.data(), static_cast<std::size_t>(q.size()));
          },
          "stamp"_a, "q"_a, "Receives measured_js of the leader (n,) [rad, m].")
      .def(
          "gripper",
          [](CrtkCycle& self, double stamp, const Eigen::VectorXd& q) {
            self.gripper(stamp, q.data(), static_cast<std::size_t>(q.size()));
          },
          "stamp"_a, "q"_a, "Receives gripper/measured_js of the leader (1,) [rad].")
      .def(
          "follower_pose",
          [](CrtkCycle& self, double stamp, const Vec3& p, const Eigen::Vector4d& quat, double t, double wall) {
            self.follower_pose(stamp, p, quat, {t, wall});
          },
          "stamp"_a, "p_BT"_a, "quat_xyzw"_a, "t"_a, "wall"_a, "Receives measured_cp of the follower [m].")
      .def(
          "follower_joints",
          [](CrtkCycle& self, double stamp, const Eigen::VectorXd& q, double t, double wall) {
            self.follower_joints(stamp, q.data(), static_cast<std::size_t>(q.size()), {t, wall});
          },
          "stamp"_a, "q"_a, "t"_a, "wall"_a, "Receives measured_js of the follower (n,) [rad, m].")
      .def(
          "jaw",
          [](CrtkCycle& self, double stamp, const Eigen::VectorXd& q) {
            self.jaw(stamp, q.data(), static_cast<std::size_t>(q.size()));
          },
          "stamp"_a, "q"_a, "Receives jaw/measured_js of the follower (1,) [rad].");
}

void bind_crtk_cycle(nb::module_& m) {
  nb::class_<CrtkCycle> cycle(
      m, "CrtkCycle",
      "Haptic cycle from stamped messages to a wrench for the leader; it contains no network code. stamp: time of the "
      "sender since 1970 [s]; t: monotonic time [s]; wall: system time since 1970 [s].");
  cycle.def(nb::init<const CrtkOptions&, std::optional<arm::Arm>>(), "options"_a, "follower"_a = nb::none());
  bind_messages(cycle);
  cycle
      .def("set_scale", &CrtkCycle::set_scale, "scale"_a,
           "Sets the motion scale reported by another program's teleoperation [-].")
      .def("set_gates", &CrtkCycle::set_gates, "gates"_a, "Sets the states of console and arms.")
      .def("set_controls", &CrtkCycle::set_controls, "controls"_a, "Sets the operator's controls.")
      .def(
          "set_scene",
          [](CrtkCycle& self, const scene::Snapshot& scene) {
            self.set_scene(scene);
            self.forget_contacts();
          },
          "snapshot"_a, nb::keep_alive<1, 2>(), "Replaces the scene; contact is reset.")
      .def("drop", &CrtkCycle::reset_wrench,
           "Resets the rendered force to zero, after another program has set it to zero.")
      .def("step", &step, "t"_a, "wall"_a,
           "One tick at time t [s]: (row of signals, wrench (6,) [N, N m] or None if no wrench may be sent, goal X_BT "
           "(4, 4) or None, jaw [rad]).");
}

}  // namespace

void bind_crtk(nb::module_& m) {
  bind_crtk_options(m);
  bind_crtk_cycle(m);
}

}  // namespace palpate::bindings
