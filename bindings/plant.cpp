#include "bindings.hpp"
#include "convert.hpp"
#include "palpate/plant/follower.hpp"
#include "palpate/plant/hand.hpp"
#include "palpate/plant/leader.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace palpate::bindings {
namespace {

using plant::FollowerOptions;
using plant::HandOptions;
using plant::LeaderOptions;

void bind_options(nb::module_& m) {
  nb::class_<HandOptions>(m, "HandOptions", "The operator's hand: a mass on the handle, spring and damper to its path.")
      .def(nb::init<>())
      .def_rw("mass", &HandOptions::mass, "moves with the handle [kg]")
      .def_rw("damping", &HandOptions::damping, "to the intended path [N s/m]")
      .def_rw("stiffness", &HandOptions::stiffness, "to the intended path [N/m]")
      .def_rw("inertia", &HandOptions::inertia, "rotational, moves with the handle [kg m^2]")
      .def_rw("rotational_damping", &HandOptions::rotational_damping, "[N m s/rad]")
      .def_rw("rotational_stiffness", &HandOptions::rotational_stiffness, "[N m/rad]")
      .def_rw("grip_force_max", &HandOptions::grip_force_max, "the hand slips above it [N]");

  nb::class_<LeaderOptions> leader(m, "LeaderOptions",
                                   "What a leader is made of; palpate.Arm.leader_options() fills it.");
  leader.def(nb::init<>())
      .def_prop_rw(
          "coupling", [](const LeaderOptions& o) -> Eigen::MatrixXd { return o.coupling; },
          [](LeaderOptions& o, const Eigen::MatrixXd& A) { o.coupling = joint_matrix(A, "coupling"); },
          "(n,n) A: q_joint = A q_motor")
      .def_rw("loop_delay", &LeaderOptions::loop_delay, "from command to torque, force term only [s]")
      .def_rw("hold_timeout", &LeaderOptions::hold_timeout, "without a fresh command the force ramps to zero [s]")
      .def_rw("quantised", &LeaderOptions::quantised, "encoder resolution and velocity estimation on or off");
  joint_field(leader, "encoder_step", &LeaderOptions::encoder_step, "(n,) motor side [rad/count]; 0 = ideal");
  joint_field(leader, "coulomb", &LeaderOptions::coulomb, "(n,) Fc [N m]");
  joint_field(leader, "viscous", &LeaderOptions::viscous, "(n,) Fv [N m s/rad]");
  joint_field(leader, "rotor_inertia", &LeaderOptions::rotor_inertia, "(n,) reflected to the joint [kg m^2]");
  joint_field(leader, "tau_max", &LeaderOptions::tau_max, "(n,) drive limits, joint side [N m]");

  nb::class_<FollowerOptions> follower(m, "FollowerOptions", "Joint servos of a simulated follower.");
  follower.def(nb::init<>())
      .def_rw("bandwidth", &FollowerOptions::bandwidth, "natural frequency of the joint servos [Hz]; 0 = ideal")
      .def_rw("damping_ratio", &FollowerOptions::damping_ratio)
      .def_rw("jaw_v_max", &FollowerOptions::jaw_v_max, "[rad/s]");
  joint_field(follower, "v_max", &FollowerOptions::v_max, "(n,) [rad/s, m/s]");
  joint_field(follower, "encoder_step", &FollowerOptions::encoder_step, "(n,) [rad, m]; 0 = ideal");
}

}  // namespace

void bind_plant(nb::module_& m) { bind_options(m); }

}  // namespace palpate::bindings
