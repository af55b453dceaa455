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

/// As cycles of arms known by their joints are told; what is theirs alone is left behind.
CrtkOptions from_cycle(const loop::CycleOptions& o, const Eigen::VectorXd& q_follower0) {
  CrtkOptions c;
  static_cast<loop::HapticsOptions&>(c) = o;
  c.X_WB = o.X_WB;
  c.q_follower0 = joint_vector(q_follower0, "q_follower0");
  c.watch.stale_after = o.stability.stale_after;
  return c;
}

void bind_options(nb::module_& m) {
  nb::class_<WatchOptions>(m, "WatchOptions", "What a stream of stamped messages may do.")
      .def(nb::init<>())
      .def_rw("stale_after", &WatchOptions::stale_after,
              "silence, age and jump of a clock beyond which it is a fault [s]")
      .def_rw("v_max", &WatchOptions::v_max, "nothing moves faster [m/s]")
      .def_rw("w_max", &WatchOptions::w_max, "nothing turns faster [rad/s]")
      .def_rw("p_slack", &WatchOptions::p_slack, "on top of it, for jitter of stamps [m]")
      .def_rw("R_slack", &WatchOptions::R_slack, "on top of it [rad]");

  nb::class_<CrtkOptions>(m, "CrtkOptions", "The haptic cycle of devices known by poses and wrenches (CRTK).")
      .def(nb::new_(&from_cycle), "cycle"_a, "q_follower0"_a = Eigen::VectorXd(),
           "As the cycle of arms known by their joints is told: X_WL and X_WB are those of measured_cp here.")
      .def_prop_ro("rate", [](const CrtkOptions& o) { return o.rate; })
      .def_prop_rw(
          "stability", [](const CrtkOptions& o) { return o.stability; },
          [](CrtkOptions& o, const stability::Options& s) { o.stability = s; })
      .def_rw("own_teleop", &CrtkOptions::own_teleop, "we move the follower")
      .def_rw("virtual_follower", &CrtkOptions::virtual_follower, "there is none: the tool is where the map puts it")
      .def_rw("tip_frame", &CrtkOptions::tip_frame, "wrenches in the tip's frame, in place of that of measured_cp")
      .def_rw("needs_operator", &CrtkOptions::needs_operator, "of a teleoperation of ours: somebody is at the console")
      .def_rw("needs_state", &CrtkOptions::needs_state, "operating states must be told")
      .def_rw("watch", &CrtkOptions::watch)
      .def_rw("release", &CrtkOptions::release, "from a fault or a pedal to zero force [s]")
      .def_rw("settle", &CrtkOptions::settle, "all must be well for so long after a fault [s]")
      .def_rw("lag_most", &CrtkOptions::lag_most, "of a follower behind its goal [m]")
      .def_rw("slowest", &CrtkOptions::slowest, "periods of the cycle between two states of the leader, in the mean");

  nb::class_<CrtkGates>(m, "CrtkGates", "What the console and the arms say about themselves; unknown is no.")
      .def(nb::init<>())
      .def_rw("following", &CrtkGates::following)
      .def_rw("operator_present", &CrtkGates::operator_present)
      .def_rw("clutch", &CrtkGates::clutch)
      .def_rw("leader_enabled", &CrtkGates::leader_enabled)
      .def_rw("follower_enabled", &CrtkGates::follower_enabled)
      .def_rw("second_writer", &CrtkGates::second_writer)
      .def_rw("other_teleop", &CrtkGates::other_teleop)
      .def_rw("frame_unsure", &CrtkGates::frame_unsure)
      .def_rw("guarded", &CrtkGates::guarded);
}

Tuple<Array, std::optional<Vec6>, std::optional<Matrix4>, double> step(CrtkCycle& self, double t, double wall) {
  const loop::CrtkOutput& out = self.step({t, wall});
  const auto goal = out.move ? std::optional(to_matrix(out.X_BT_goal)) : std::nullopt;
  return nb::make_tuple(to_row(out.tick), out.command ? std::optional<Vec6>(to_vector(out.F)) : std::nullopt, goal,
                        out.jaw);
}

void bind_cycle(nb::module_& m) {
  nb::class_<CrtkCycle>(m, "CrtkCycle", "Stamped messages in, a wrench for the leader out; no network in it.")
      .def(nb::init<const CrtkOptions&, std::optional<arm::Arm>>(), "options"_a, "follower"_a = nb::none())
      .def(
          "leader_pose",
          [](CrtkCycle& self, double stamp, const Vec3& p, const Eigen::Vector4d& quat, double t, double wall) {
            self.leader_pose(stamp, p, quat, {t, wall});
          },
          "stamp"_a, "p_LH"_a, "quat_xyzw"_a, "t"_a, "wall"_a)
      .def(
          "leader_twist",
          [](CrtkCycle& self, double stamp, const Vec3& v, const Vec3& w, double t, double wall) {
            self.leader_twist(stamp, {v, w}, {t, wall});
          },
          "stamp"_a, "v_LH"_a, "w_LH"_a, "t"_a, "wall"_a)
      .def(
          "leader_joints",
          [](CrtkCycle& self, double stamp, const Eigen::VectorXd& q) {
            self.leader_joints(stamp, q.data(), static_cast<std::size_t>(q.size()));
          },
          "stamp"_a, "q"_a)
      .def(
          "gripper",
          [](CrtkCycle& self, double stamp, const Eigen::VectorXd& q) {
            self.gripper(stamp, q.data(), static_cast<std::size_t>(q.size()));
          },
          "stamp"_a, "q"_a)
      .def(
          "follower_pose",
          [](CrtkCycle& self, double stamp, const Vec3& p, const Eigen::Vector4d& quat, double t, double wall) {
            self.follower_pose(stamp, p, quat, {t, wall});
          },
          "stamp"_a, "p_BT"_a, "quat_xyzw"_a, "t"_a, "wall"_a)
      .def(
          "follower_joints",
          [](CrtkCycle& self, double stamp, const Eigen::VectorXd& q, double t, double wall) {
            self.follower_joints(stamp, q.data(), static_cast<std::size_t>(q.size()), {t, wall});
          },
          "stamp"_a, "q"_a, "t"_a, "wall"_a)
      .def(
          "jaw",
          [](CrtkCycle& self, double stamp, const Eigen::VectorXd& q) {
            self.jaw(stamp, q.data(), static_cast<std::size_t>(q.size()));
          },
          "stamp"_a, "q"_a)
      .def("set_scale", &CrtkCycle::set_scale, "scale"_a, "Motion scale of somebody else's teleoperation.")
      .def("set_gates", &CrtkCycle::set_gates, "gates"_a)
      .def("set_controls", &CrtkCycle::set_controls, "controls"_a)
      .def("set_scene", &CrtkCycle::set_scene, "snapshot"_a, nb::keep_alive<1, 2>())
      .def("drop", &CrtkCycle::drop, "Somebody else has put the force to zero.")
      .def("step", &step, "t"_a, "wall"_a,
           "One tick: (row, wrench (6,) or None when nothing may be sent, goal (4, 4) or None, jaw).");
}

}  // namespace

void bind_crtk(nb::module_& m) {
  bind_options(m);
  bind_cycle(m);
}

}  // namespace palpate::bindings
