#include "bindings.hpp"
#include "convert.hpp"
#include "doc.hpp"
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

void bind_hand_options(nb::module_& m) {
  nb::class_<HandOptions>(
      m, "HandOptions",
      "Impedance of the operator's hand: a mass on the handle, with a spring and a damper to its intended path.")
      .def(nb::init<>())
      .def_rw("mass", &HandOptions::mass, "Mass that moves with the handle [kg]."_doc)
      .def_rw("damping", &HandOptions::damping, "Damping to the intended path [N s/m]."_doc)
      .def_rw("stiffness", &HandOptions::stiffness, "Stiffness to the intended path [N/m]."_doc)
      .def_rw("inertia", &HandOptions::inertia, "Rotational inertia that moves with the handle [kg m^2]."_doc)
      .def_rw("rotational_damping", &HandOptions::rotational_damping, "Rotational damping [N m s/rad]."_doc)
      .def_rw("rotational_stiffness", &HandOptions::rotational_stiffness, "Rotational stiffness [N m/rad]."_doc)
      .def_rw("grip_force_max", &HandOptions::grip_force_max,
              "Largest force of the grip; the hand slips above it [N]."_doc);
}

void bind_leader_options(nb::module_& m) {
  nb::class_<LeaderOptions> leader(m, "LeaderOptions",
                                   "Parameters of a simulated leader; palpate.Arm.leader_options() fills them.");
  leader.def(nb::init<>())
      .def_prop_rw(
          "coupling", [](const LeaderOptions& o) -> Eigen::MatrixXd { return o.coupling; },
          [](LeaderOptions& o, const Eigen::MatrixXd& A) { o.coupling = joint_matrix(A, "coupling"); },
          "Coupling matrix A (n,n): q_joint = A q_motor.")
      .def_rw("loop_delay", &LeaderOptions::loop_delay,
              "Delay from the command to the torque, of the force term only [s]."_doc)
      .def_rw("loop_jitter", &LeaderOptions::loop_jitter,
              "Additional random delay of each command, uniform in 0..loop_jitter [s]."_doc)
      .def_rw("drive_lag", &LeaderOptions::drive_lag,
              "Time constant of the drives' current loops, which all torque terms pass [s]."_doc)
      .def_rw("velocity_window", &LeaderOptions::velocity_window,
              "Time between the two positions whose difference gives a velocity [s]; 0: velocities come from the time "
              "between encoder edges."_doc)
      .def_rw("velocity_cutoff", &LeaderOptions::velocity_cutoff,
              "Cutoff of the first-order low-pass on velocities [Hz]; 0: no low-pass."_doc)
      .def_rw("hold_timeout", &LeaderOptions::hold_timeout,
              "Time without a new command after which the force term ramps to zero [s]."_doc)
      .def_rw("cell_noise", &LeaderOptions::cell_noise, "Noise of the load cell in the handle, rms per axis [N]."_doc)
      .def_rw("seed", &LeaderOptions::seed,
              "Seed of the load cell's noise and of the jitter; a Simulation replaces it by its own."_doc)
      .def_rw("quantised", &LeaderOptions::quantised,
              "True: positions and velocities come from the encoders; False: they are exact."_doc);
  joint_field(leader, "encoder_step", &LeaderOptions::encoder_step,
              "Resolution of the encoders on the motor side (n,) [rad/count]; 0: exact.");
  joint_field(leader, "coulomb", &LeaderOptions::coulomb, "Coulomb friction of the joints (n,) [N m].");
  joint_field(leader, "viscous", &LeaderOptions::viscous, "Viscous friction of the joints (n,) [N m s/rad].");
  joint_field(leader, "rotor_inertia", &LeaderOptions::rotor_inertia,
              "Rotor inertias, reflected to the joints (n,) [kg m^2].");
  joint_field(leader, "tau_max", &LeaderOptions::tau_max, "Torque limits of the drives, joint side (n,) [N m].");
}

void bind_follower_options(nb::module_& m) {
  nb::class_<plant::DriveOptions> drives(m, "DriveOptions", "Parameters of a follower's drives, at its joints.");
  drives.def(nb::init<>());
  joint_field(drives, "coulomb", &plant::DriveOptions::coulomb, "Coulomb friction (n,) [N m, N].");
  joint_field(drives, "viscous", &plant::DriveOptions::viscous, "Viscous friction (n,) [N m s/rad, N s/m].");
  joint_field(drives, "rotor_inertia", &plant::DriveOptions::rotor_inertia, "Rotor inertias (n,) [kg m^2, kg].");

  nb::class_<FollowerOptions> follower(m, "FollowerOptions", "Parameters of a simulated follower.");
  follower.def(nb::init<>())
      .def_rw("bandwidth", &FollowerOptions::bandwidth, "Natural frequency of the joint servos [Hz]; 0: ideal."_doc)
      .def_rw("damping_ratio", &FollowerOptions::damping_ratio,
              "Damping ratio of the joint servos [-]; 1: no overshoot."_doc)
      .def_rw("jaw_v_max", &FollowerOptions::jaw_v_max, "Speed limit of the jaw [rad/s]."_doc)
      .def_rw("driven", &FollowerOptions::driven,
              "True: drives move the joints by torques, and contact forces push against them; False: position servos "
              "move the joints."_doc)
      .def_rw("drives", &FollowerOptions::drives, "Drives of a driven follower."_doc);
  joint_field(follower, "v_max", &FollowerOptions::v_max, "Speed limits of the joints (n,) [rad/s, m/s].");
  joint_field(follower, "encoder_step", &FollowerOptions::encoder_step,
              "Resolution of the encoders (n,) [rad, m]; 0: exact.");
}

void bind_leader(nb::module_& m) {
  nb::class_<plant::Leader>(m, "Leader",
                            "A simulated leader: dynamics, friction, drives and encoders, and the hand that holds it.")
      .def(nb::init<arm::Arm, LeaderOptions, HandOptions>(), "arm"_a, "options"_a, "hand"_a = HandOptions{})
      .def(
          "reset", [](plant::Leader& l, const Vector& q) { l.reset(joint_vector(q, "q", l.q().size())); }, "q"_a,
          "Places the arm at rest at q (n,), clipped to the limits, with drives off, and sets the time to zero.")
      .def(
          "command",
          [](plant::Leader& l, const Vector& force, const Vector& gravity, const Vector& platform) {
            const Eigen::Index n = l.q().size();
            LeaderCommand command(n);
            command.tau_force = joint_vector(force, "tau_force", n);
            command.tau_gravity = joint_vector(gravity, "tau_gravity", n);
            command.tau_platform = joint_vector(platform, "tau_platform", n);
            l.command(command);
          },
          "tau_force"_a, "tau_gravity"_a, "tau_platform"_a,
          "Commands torques (n,) [N m]; the drives hold them until the next command.")
      .def(
          "obey", [](plant::Leader& l, const LeaderCommand& command) { l.command(command); }, "command"_a,
          "Commands all terms of a command of the stage `torque`.")
      .def("pinch", &plant::Leader::pinch, "gripper"_a, "The hand closes the gripper to this angle [rad]; 0: closed.")
      .def(
          "step",
          [](plant::Leader& l, double dt, const Matrix4& X, const Vec6& V, int n) {
            const Pose X_LH = to_pose(X, "X_LH_hand");
            for (int k = 0; k < n; ++k) l.step(dt, X_LH, {V.head<3>(), V.tail<3>()});
          },
          "dt"_a, "X_LH_hand"_a, "V_LH_hand"_a = Vec6(Vec6::Zero()), "n"_a = 1,
          "Simulates n servo periods of dt [s]. The hand intends the handle at X_LH_hand (4,4), moving with V_LH_hand "
          "(6,).")
      .def_prop_ro(
          "t", [](const plant::Leader& l) { return l.measured().t; }, "Time [s].")
      .def_prop_ro(
          "q_measured", [](const plant::Leader& l) -> Vector { return l.measured().q; },
          "Joint positions by the encoders (n,) [rad].")
      .def_prop_ro(
          "v_measured", [](const plant::Leader& l) -> Vector { return l.measured().v; },
          "Joint velocities by the encoders (n,) [rad/s].")
      .def_prop_ro(
          "gripper", [](const plant::Leader& l) { return l.measured().gripper; }, "Measured gripper angle [rad].")
      .def_prop_ro(
          "q", [](const plant::Leader& l) -> Vector { return l.q(); }, "True joint positions (n,) [rad].")
      .def_prop_ro(
          "v", [](const plant::Leader& l) -> Vector { return l.v(); }, "True joint velocities (n,) [rad/s].")
      .def_prop_ro(
          "load_cell", [](const plant::Leader& l) -> Vector { return to_vector(l.load_cell()); },
          "True wrench of the arm on the hand, in L (6,) [N, N m].")
      .def_prop_ro(
          "F_cell_L", [](const plant::Leader& l) -> Vector { return l.measured().F_cell_L; },
          "Force measured by the load cell, noise included (3,) [N].")
      .def_prop_ro("hand_slipped", &plant::Leader::hand_slipped,
                   "True if the force of the grip reached its limit in the last step.")
      .def_prop_ro("energy", &plant::Leader::energy,
                   "Kinetic plus potential energy [J]; the weight of the hand is not included.");
}

void bind_follower(nb::module_& m) {
  nb::class_<plant::Follower>(m, "Follower", "A simulated follower: joints under position control, and a jaw.")
      .def(nb::init<const arm::Arm&, FollowerOptions>(), "arm"_a, "options"_a)
      .def(
          "reset",
          [](plant::Follower& f, const Vector& q, double jaw) {
            f.reset(joint_vector(q, "q", f.measured().q.size()), jaw);
          },
          "q"_a, "jaw"_a = 0.0, "Places the arm at rest at q (n,) [rad, m] with this jaw angle [rad].")
      .def(
          "command",
          [](plant::Follower& f, const Vector& q, double jaw) {
            f.command({joint_vector(q, "q", f.measured().q.size()), jaw, true});
          },
          "q"_a, "jaw"_a = 0.0, "Commands joint positions q (n,) [rad, m] and a jaw angle [rad].")
      .def(
          "step",
          [](plant::Follower& f, double dt, int n, const Vec6& F) {
            for (int k = 0; k < n; ++k) f.step(dt, {F.head<3>(), F.tail<3>()});
          },
          "dt"_a, "n"_a = 1, "F_T_B"_a = Vec6(Vec6::Zero()),
          "Simulates n servo periods of dt [s]. F_T_B (6,): wrench of the environment on the tip, which moves a driven "
          "follower only [N, N m].")
      .def_prop_ro(
          "t", [](const plant::Follower& f) { return f.measured().t; }, "Time [s].")
      .def_prop_ro(
          "q", [](const plant::Follower& f) -> Vector { return f.measured().q; },
          "Measured joint positions (n,) [rad, m].")
      .def_prop_ro(
          "v", [](const plant::Follower& f) -> Vector { return f.measured().v; },
          "Measured joint velocities (n,) [rad/s, m/s]; empty unless the follower is driven.")
      .def_prop_ro(
          "tau", [](const plant::Follower& f) -> Vector { return f.measured().tau; },
          "Torques of the drives (n,) [N m, N]; empty unless the follower is driven.")
      .def_prop_ro("jaw", [](const plant::Follower& f) { return f.measured().jaw; }, "Measured jaw angle [rad].");
}

}  // namespace

void bind_plant(nb::module_& m) {
  bind_hand_options(m);
  bind_leader_options(m);
  bind_follower_options(m);
  bind_leader(m);
  bind_follower(m);
}

}  // namespace palpate::bindings
