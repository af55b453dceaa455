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
      .def_rw("loop_jitter", &LeaderOptions::loop_jitter, "on top of it: uniform from 0 to this, each command [s]")
      .def_rw("drive_lag", &LeaderOptions::drive_lag, "time constant of the drives' current loops, of all torque [s]")
      .def_rw("velocity_window", &LeaderOptions::velocity_window,
              "0: time between edges; else the difference of two positions so far apart [s]")
      .def_rw("velocity_cutoff", &LeaderOptions::velocity_cutoff, "first-order low-pass of velocities; 0 = none [Hz]")
      .def_rw("hold_timeout", &LeaderOptions::hold_timeout, "without a fresh command the force ramps to zero [s]")
      .def_rw("cell_noise", &LeaderOptions::cell_noise, "of the load cell in the handle, rms per axis [N]")
      .def_rw("seed", &LeaderOptions::seed, "of that noise and of the jitter; a simulation takes its own")
      .def_rw("quantised", &LeaderOptions::quantised, "encoders as above, or the truth");
  joint_field(leader, "encoder_step", &LeaderOptions::encoder_step, "(n,) motor side [rad/count]; 0 = ideal");
  joint_field(leader, "coulomb", &LeaderOptions::coulomb, "(n,) Fc [N m]");
  joint_field(leader, "viscous", &LeaderOptions::viscous, "(n,) Fv [N m s/rad]");
  joint_field(leader, "rotor_inertia", &LeaderOptions::rotor_inertia, "(n,) reflected to the joint [kg m^2]");
  joint_field(leader, "tau_max", &LeaderOptions::tau_max, "(n,) drive limits, joint side [N m]");

  nb::class_<plant::DriveOptions> drives(m, "DriveOptions", "The drives of a follower, at its joints.");
  drives.def(nb::init<>());
  joint_field(drives, "coulomb", &plant::DriveOptions::coulomb, "(n,) Fc [N m, N]");
  joint_field(drives, "viscous", &plant::DriveOptions::viscous, "(n,) Fv [N m s/rad, N s/m]");
  joint_field(drives, "rotor_inertia", &plant::DriveOptions::rotor_inertia, "(n,) [kg m^2, kg]");

  nb::class_<FollowerOptions> follower(m, "FollowerOptions", "Joint servos of a simulated follower.");
  follower.def(nb::init<>())
      .def_rw("bandwidth", &FollowerOptions::bandwidth, "natural frequency of the joint servos [Hz]; 0 = ideal")
      .def_rw("damping_ratio", &FollowerOptions::damping_ratio)
      .def_rw("jaw_v_max", &FollowerOptions::jaw_v_max, "[rad/s]")
      .def_rw("driven", &FollowerOptions::driven, "joints moved by drives with torques, which contacts push against")
      .def_rw("drives", &FollowerOptions::drives, "of a driven follower");
  joint_field(follower, "v_max", &FollowerOptions::v_max, "(n,) [rad/s, m/s]");
  joint_field(follower, "encoder_step", &FollowerOptions::encoder_step, "(n,) [rad, m]; 0 = ideal");
}

using Vector = Eigen::VectorXd;

void bind_leader(nb::module_& m) {
  nb::class_<plant::Leader>(m, "Leader", "A simulated leader: dynamics, friction, drives, encoders, and a hand on it.")
      .def(nb::init<arm::Arm, LeaderOptions, HandOptions>(), "arm"_a, "options"_a, "hand"_a = HandOptions{})
      .def(
          "reset", [](plant::Leader& l, const Vector& q) { l.reset(joint_vector(q, "q", l.q().size())); }, "q"_a,
          "At rest at q (n,), within the limits; drives off, time zero.")
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
          "tau_force"_a, "tau_gravity"_a, "tau_platform"_a, "The newest torques (n,) [N m]; held until the next.")
      .def(
          "obey", [](plant::Leader& l, const LeaderCommand& command) { l.command(command); }, "command"_a,
          "The newest command of a Torque stage, every term of it.")
      .def("pinch", &plant::Leader::pinch, "gripper"_a, "The hand closes the grips to this angle, 0 = closed [rad].")
      .def(
          "step",
          [](plant::Leader& l, double dt, const Matrix4& X, const Vec6& V, int n) {
            const Pose X_LH = to_pose(X, "X_LH_hand");
            for (int k = 0; k < n; ++k) l.step(dt, X_LH, {V.head<3>(), V.tail<3>()});
          },
          "dt"_a, "X_LH_hand"_a, "V_LH_hand"_a = Vec6(Vec6::Zero()), "n"_a = 1,
          "n servo periods of dt [s] with the hand wanting the handle at X_LH_hand (4,4), moving with V (6,).")
      .def_prop_ro(
          "t", [](const plant::Leader& l) { return l.measured().t; }, "[s]")
      .def_prop_ro(
          "q_measured", [](const plant::Leader& l) -> Vector { return l.measured().q; }, "encoders [rad]")
      .def_prop_ro(
          "v_measured", [](const plant::Leader& l) -> Vector { return l.measured().v; }, "encoders [rad/s]")
      .def_prop_ro(
          "gripper", [](const plant::Leader& l) { return l.measured().gripper; }, "[rad]")
      .def_prop_ro(
          "q", [](const plant::Leader& l) -> Vector { return l.q(); }, "truth [rad]")
      .def_prop_ro(
          "v", [](const plant::Leader& l) -> Vector { return l.v(); }, "truth [rad/s]")
      .def_prop_ro(
          "load_cell", [](const plant::Leader& l) -> Vector { return to_vector(l.load_cell()); },
          "force and torque of the arm on the hand, in L (6,), the truth [N, N m]")
      .def_prop_ro(
          "F_cell_L", [](const plant::Leader& l) -> Vector { return l.measured().F_cell_L; },
          "what the load cell says (3,), noise included [N]")
      .def_prop_ro("hand_slipped", &plant::Leader::hand_slipped, "the grip force limit was reached in the last step")
      .def_prop_ro("energy", &plant::Leader::energy, "kinetic + potential [J]; the hand carries its own weight");
}

void bind_follower(nb::module_& m) {
  nb::class_<plant::Follower>(m, "Follower", "A simulated follower: position-servoed joints and a jaw.")
      .def(nb::init<const arm::Arm&, FollowerOptions>(), "arm"_a, "options"_a)
      .def(
          "reset",
          [](plant::Follower& f, const Vector& q, double jaw) {
            f.reset(joint_vector(q, "q", f.measured().q.size()), jaw);
          },
          "q"_a, "jaw"_a = 0.0)
      .def(
          "command",
          [](plant::Follower& f, const Vector& q, double jaw) {
            f.command({joint_vector(q, "q", f.measured().q.size()), jaw, true});
          },
          "q"_a, "jaw"_a = 0.0, "Where the joints (n,) [rad, m] and the jaw [rad] shall go.")
      .def(
          "step",
          [](plant::Follower& f, double dt, int n, const Vec6& F) {
            for (int k = 0; k < n; ++k) f.step(dt, {F.head<3>(), F.tail<3>()});
          },
          "dt"_a, "n"_a = 1, "F_T_B"_a = Vec6(Vec6::Zero()),
          "n servo periods of dt [s]; F_T_B (6,): environment on the tip, felt by a driven follower [N, N m].")
      .def_prop_ro(
          "t", [](const plant::Follower& f) { return f.measured().t; }, "[s]")
      .def_prop_ro(
          "q", [](const plant::Follower& f) -> Vector { return f.measured().q; }, "measured [rad, m]")
      .def_prop_ro(
          "v", [](const plant::Follower& f) -> Vector { return f.measured().v; }, "measured; empty unless driven")
      .def_prop_ro(
          "tau", [](const plant::Follower& f) -> Vector { return f.measured().tau; },
          "of the drives [N m, N]; empty unless driven")
      .def_prop_ro("jaw", [](const plant::Follower& f) { return f.measured().jaw; }, "[rad]");
}

}  // namespace

void bind_plant(nb::module_& m) {
  bind_options(m);
  bind_leader(m);
  bind_follower(m);
}

}  // namespace palpate::bindings
