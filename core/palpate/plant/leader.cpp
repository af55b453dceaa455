#include "palpate/plant/leader.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>

#include "palpate/plant/drive.hpp"
#include "palpate/plant/dry_friction.hpp"
#include "palpate/plant/encoders.hpp"
#include "palpate/plant/leader_kernels.hpp"
#include "palpate/types/random.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::plant {
namespace {

constexpr double kDelayMax = 1.0;  // [s]

void check_sizes(const LeaderOptions& o, Eigen::Index n) {
  const auto check = [n](const char* name, const JointVector& x, bool positive) {
    if (x.size() != n) {
      throw std::invalid_argument("leader " + std::string(name) + " needs " + std::to_string(n) +
                                  " entries, one per joint; got " + std::to_string(x.size()) +
                                  " (Arm.leader_options() fills them)");
    }
    if (!(positive ? (x.array() > 0.0).all() : (x.array() >= 0.0).all())) {
      throw std::invalid_argument("leader " + std::string(name) + " must be " + (positive ? "above" : "at least") +
                                  " zero for every joint");
    }
  };
  check("encoder_step", o.encoder_step, false);
  check("coulomb", o.coulomb, false);
  check("viscous", o.viscous, false);
  check("rotor_inertia", o.rotor_inertia, false);
  check("tau_max", o.tau_max, true);
  if (o.coupling.rows() != n || o.coupling.cols() != n || std::abs(o.coupling.determinant()) < 1e-9) {
    throw std::invalid_argument("leader coupling must be an invertible " + std::to_string(n) + " x " +
                                std::to_string(n) + " matrix A, q_joint = A q_motor (the identity when there is none)");
  }
}

void check_values(const LeaderOptions& o, const HandOptions& h) {
  const auto within = [](const char* name, double x, double most, const char* unit) {
    if (x >= 0.0 && x <= most) return;
    std::ostringstream words;
    words << "leader " << name << " must lie in 0.." << most << ' ' << unit << "; got " << x << ' ' << unit;
    throw std::invalid_argument(words.str());
  };
  within("loop_delay", o.loop_delay, kDelayMax, "s");
  within("loop_jitter", o.loop_jitter, kDelayMax, "s");
  within("drive_lag", o.drive_lag, kDelayMax, "s");
  within("velocity_window", o.velocity_window, kDelayMax, "s");
  within("velocity_cutoff", o.velocity_cutoff, 1e5, "Hz");
  within("cell_noise", o.cell_noise, 10.0, "N");
  if (!(o.hold_timeout > 0.0)) {
    throw std::invalid_argument("leader hold_timeout must be above zero; got " + std::to_string(o.hold_timeout) + " s");
  }
  const bool good = h.mass >= 0.0 && h.damping >= 0.0 && h.stiffness >= 0.0 && h.inertia >= 0.0 &&
                    h.rotational_damping >= 0.0 && h.rotational_stiffness >= 0.0 && h.grip_force_max > 0.0;
  if (!good) {
    throw std::invalid_argument(
        "the hand's mass, damping, stiffness and inertia must not be below zero, grip_force_max above zero");
  }
}

/// Rotation vector from R_from to R_to, in the axes in which both are expressed.
Vec3 turn_between(const Mat3& R_from, const Mat3& R_to) noexcept { return rotation_vector(R_to * R_from.transpose()); }

/// Copies all lanes: faster than as many numbers as the vector has.
void copy(const JointVector& from, JointVector& to) noexcept {
  to.resize(from.size());
  std::copy_n(lanes(from), kLanes, lanes(to));
}

Six& as_array(Vec6& x) noexcept { return *reinterpret_cast<Six*>(x.data()); }
const Six& as_array(const Vec6& x) noexcept { return *reinterpret_cast<const Six*>(x.data()); }

}  // namespace

// The step with h = dt. All terms are evaluated at its middle, q' = q + h/2 v:
//   (M + I_r + J^T M_h J) (v+ - v) = h (tau - C v - G - E - D v+ + J^T (F_hand+ - M_h dJ v)) + friction + stops
//   F_hand+ = K (x_path - x' - h/2 J v+) + B (xdot_path - J v+)         spring and damper at the END of the step
//   q+ = q' + h/2 v+
// E is the torque of the counterbalance. A stiff hand on a light wrist is stable because v+ appears on both sides.
// Without friction and damping the midpoint makes the step second order, so that a free swing keeps its energy.
struct Leader::Impl {
  Impl(arm::Arm a, LeaderOptions o, HandOptions h)
      : arm(std::move(a)),
        options(std::move(o)),
        hand(h),
        drive({options.loop_delay, options.loop_jitter, options.drive_lag, options.hold_timeout, options.tau_max,
               options.seed}),
        encoders({options.coupling, options.encoder_step, options.velocity_window, options.velocity_cutoff}),
        random(options.seed) {
    pad(options.coulomb, joints.coulomb);
    pad(options.viscous, joints.viscous);
    pad(options.rotor_inertia, joints.rotor);
    pad(arm.q_min(), joints.q_min);
    pad(arm.q_max(), joints.q_max);
    grip(hand);
  }

  void grip(const HandOptions& h) noexcept {
    hand = h;
    M_hand << Vec3::Constant(hand.mass), Vec3::Constant(hand.inertia);
    K << Vec3::Constant(hand.stiffness), Vec3::Constant(hand.rotational_stiffness);
    B << Vec3::Constant(hand.damping), Vec3::Constant(hand.rotational_damping);
  }

  void place(const JointVector& q0) noexcept {
    const JointVector zero = JointVector::Zero(q0.size());
    for (JointVector* x : {&q, &v, &v_before, &q_mid, &v_mid}) *x = zero;
    for (JointVector* x : {&v, &v_before, &v_mid}) pad(zero, lanes(*x));
    pad(q0.cwiseMax(arm.q_min()).cwiseMin(arm.q_max()), lanes(q));
    friction.reset(q.size());
    drive.reset();
    encoders.reset(q);
    cell = {};
    slipped = false;
    t = 0.0;
    random.seed(options.seed);
    state.valid = state.has_load_cell = true;
    sense();
  }

  /// Measures all but the joints. The load cell's noise takes new random numbers in every period.
  void sense() noexcept {
    read = false;
    state.t = t;
    state.gripper = gripper;
    state.F_cell_L = cell.f;
    if (options.cell_noise > 0.0) state.F_cell_L += options.cell_noise * Vec3(gauss(), gauss(), gauss());
  }

  /// The state of the last period. The joints are read on demand: a cycle asks for one period in ten.
  const LeaderState& measured() noexcept {
    if (read) return state;
    read = true;
    encoders.read();
    copy(options.quantised ? encoders.q() : q, state.q);
    copy(options.quantised ? encoders.v() : v, state.v);
    return state;
  }

  /// A normal random number of unit variance, as the sum of twelve uniform ones: the same on every machine.
  double gauss() noexcept {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform(random);
    return sum;
  }

  /// Velocity at the end of the step if the hand pushes with F - response * (velocity of the handle at that end).
  const Lanes& advance(const Vec6& F, const Vec6& response, const Vec6& V_handle, double dt) noexcept {
    const Vec6 H = M_hand + dt * response;
    const Vec6 push = M_hand.cwiseProduct(V_handle - dt * Vec6::Map(d->Jdot_v)) + dt * (F + F_push);
    alignas(64) Lanes A[kLanes], b;
    assemble(*d, joints, dt, as_array(H), as_array(push), loads.tau, lanes(v), A, b);
    return lanes(friction.solve(A, b, loads.lo, loads.hi));
  }

  void step(double dt, const Pose& X_path, const Twist& V_path, const Wrench& push) noexcept {
    F_push << push.f, push.t;
    const Lanes& tau_drives = lanes(drive.step(dt));
    to_middle(dt, lanes(q), lanes(v), lanes(v_before), lanes(q_mid), lanes(v_mid));
    alignas(64) Lanes elastic;
    pad(arm.elastic(q_mid), elastic);
    d = &arm.lane_dynamics(q_mid, v_mid, work);
    Vec6 V_before, dV;  // velocity of the handle; its change
    sum_loads(*d, joints, dt, tau_drives, elastic, lanes(q_mid), lanes(v), loads, as_array(V_before));

    using Columns = Eigen::Map<const Eigen::Matrix<double, 3, 4>, 0, Eigen::OuterStride<4>>;
    const Columns tip(d->tip[0]);
    Vec6 x_error, V;
    x_error << X_path.p - tip.col(3), turn_between(tip.leftCols<3>(), X_path.R);
    V << V_path.v, V_path.w;
    const Vec6 F0 = K.cwiseProduct(x_error) + B.cwiseProduct(V);
    const Vec6 response = 0.5 * dt * K + B;
    const auto push_with = [&](const Vec6& force, const Vec6& answer) {
      const Lanes& v_next = advance(force, answer, V_before, dt);
      change_of_velocity(*d, lanes(v), v_next, as_array(dV));
      return Vec6(force - answer.cwiseProduct(V_before + dV));
    };
    Vec6 F = push_with(F0, response);
    const double grip = F.head<3>().norm();
    slipped = grip > hand.grip_force_max;
    if (slipped) {  // the fingers slide: the force is what they can hold, whatever the velocity
      Vec6 F_slip = F0, response_slip = response;
      F_slip.head<3>() = F.head<3>() * (hand.grip_force_max / grip);
      response_slip.head<3>().setZero();
      F = push_with(F_slip, response_slip);
    }
    // Newton's law for the hand's mass: the arm's force is the mass times its acceleration minus the person's force.
    const Vec6 arm_on_hand = M_hand.cwiseProduct(dV / dt + Vec6::Map(d->Jdot_v)) - F - F_push;
    cell = {arm_on_hand.head<3>(), arm_on_hand.tail<3>()};

    to_end(dt, joints, lanes(q_mid), lanes(friction.v()), lanes(v), lanes(v_before), lanes(q));
    t += dt;
    encoders.step(lanes(q), dt);
    sense();
  }

  [[nodiscard]] double energy() noexcept {
    const arm::Dynamics& now = arm.dynamics(q, v);
    const Vec6 V = now.J * v;
    const double kinetic =
        v.dot(now.M * v) + v.dot(options.rotor_inertia.cwiseProduct(v)) + V.dot(M_hand.cwiseProduct(V));
    return 0.5 * kinetic + arm.potential_energy(q) + arm.elastic_energy(q);
  }

  arm::Arm arm;
  LeaderOptions options;
  HandOptions hand;
  Drive drive;
  Encoders encoders;
  DryFriction friction;
  Vec6 M_hand, K, B;  // inertia, stiffness and damping of the hand: linear over angular
  Vec6 F_push;
  LeaderJoints joints;
  LeaderLoads loads;
  JointVector q, v, v_before, q_mid, v_mid;  // zero beyond the last joint
  const arm::LaneDynamics* d = nullptr;      // at the middle of the step
  arm::LaneDynamics work;
  LeaderState state;
  Wrench cell;
  double gripper = 0.0, t = 0.0;
  bool slipped = false, read = false;  // read: `state` is that of the last period
  std::mt19937_64 random;
};

Leader::Leader(arm::Arm plant_model, LeaderOptions options, HandOptions hand) {
  check_sizes(options, plant_model.n());
  check_values(options, hand);
  impl_ = std::make_unique<Impl>(std::move(plant_model), std::move(options), hand);
  reset(JointVector::Zero(impl_->arm.n()));
}
Leader::Leader(Leader&&) noexcept = default;
Leader& Leader::operator=(Leader&&) noexcept = default;
Leader::~Leader() = default;

void Leader::reset(const JointVector& q) noexcept { impl_->place(q); }
void Leader::command(const LeaderCommand& command) noexcept { impl_->drive.command(command); }
void Leader::pinch(double gripper) noexcept { impl_->gripper = gripper; }
void Leader::grip(const HandOptions& hand) noexcept { impl_->grip(hand); }
void Leader::step(double dt, const Pose& X_LH_hand, const Twist& V_LH_hand, const Wrench& F_push_L) noexcept {
  impl_->step(dt, X_LH_hand, V_LH_hand, F_push_L);
}

const LeaderState& Leader::measured() const noexcept { return impl_->measured(); }
const JointVector& Leader::q() const noexcept { return impl_->q; }
const JointVector& Leader::v() const noexcept { return impl_->v; }
const Wrench& Leader::load_cell() const noexcept { return impl_->cell; }
bool Leader::hand_slipped() const noexcept { return impl_->slipped; }
double Leader::energy() const noexcept { return impl_->energy(); }

}  // namespace palpate::plant
