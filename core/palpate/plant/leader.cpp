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

/// Copies all lanes: faster than as many numbers as the vector has.
void copy(const JointVector& from, JointVector& to) noexcept {
  to.resize(from.size());
  std::copy_n(lanes(from), kLanes, lanes(to));
}

template <int rows, int cols>
const double (&numbers(const Eigen::Matrix<double, rows, cols>& x) noexcept)[rows * cols] {
  return *reinterpret_cast<const double (*)[rows * cols]>(x.data());
}

void set(const Vec3& linear, const Vec3& angular, HandleLanes& x) noexcept {
  for (int i = 0; i < 3; ++i) x[i] = linear[i], x[4 + i] = angular[i];
  x[3] = x[7] = 0.0;
}
void set(double linear, double angular, HandleLanes& x) noexcept {
  set(Vec3::Constant(linear), Vec3::Constant(angular), x);
}

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
    set(hand.mass, hand.inertia, impedance.M);
    set(hand.stiffness, hand.rotational_stiffness, impedance.K);
    set(hand.damping, hand.rotational_damping, impedance.B);
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

  /// The pull of the hand towards its path, from the pose of the handle in `d`.
  void pull_handle(const Pose& X_path, const Twist& V_path) noexcept {
    alignas(64) HandleLanes error;
    const auto &v_path = numbers(V_path.v), &w_path = numbers(V_path.w);
    if (pull_towards(*d, impedance, numbers(X_path.p), numbers(X_path.R), v_path, w_path, error, force.F)) return;
    using Columns = Eigen::Map<const Mat3, 0, Eigen::OuterStride<4>>;
    Vec3::Map(error + 4) = rotation_vector(X_path.R * Columns(d->tip[0]).transpose());
    pull(impedance, error, v_path, w_path, force.F);
  }

  /// Solves the step for the present force and response of the hand. Returns the square of the hand's linear force.
  double advance(double dt) noexcept {
    alignas(64) Lanes A[kLanes], b;
    assemble(*d, joints, impedance, dt, force, F_push, V_handle, loads, lanes(v), A, b);
    const JointVector& v_next = friction.solve(A, b, loads.lo, loads.hi);
    return react(*d, impedance, dt, force, F_push, V_handle, lanes(v), lanes(v_next), F_hand, arm_on_hand);
  }

  /// Dynamics at the middle of the step; the inertia includes that of the hand and of its response.
  void evaluate(double dt) noexcept {
    const arm::TipBody body = {hand.mass + dt * force.response[0], hand.inertia + dt * force.response[4]};
    d = &arm.lane_dynamics(q_mid, v_mid, body, work);
  }

  void step(double dt, const Pose& X_path, const Twist& V_path, const Wrench& push) noexcept {
    set(push.f, push.t, F_push);
    set(hand.damping + 0.5 * dt * hand.stiffness, hand.rotational_damping + 0.5 * dt * hand.rotational_stiffness,
        force.response);
    const Lanes& tau_drives = lanes(drive.step(dt));
    to_middle(dt, lanes(q), lanes(v), lanes(v_before), lanes(q_mid), lanes(v_mid));
    alignas(64) Lanes elastic;
    arm.elastic(q_mid, elastic);
    evaluate(dt);
    sum_loads(*d, joints, dt, tau_drives, elastic, lanes(q_mid), lanes(v), loads, V_handle);
    pull_handle(X_path, V_path);
    const double most = hand.grip_force_max, squared_force = advance(dt);
    slipped = squared_force > most * most;
    if (slipped) {  // the fingers slide: the force is what they can hold, whatever the velocity
      for (int i = 0; i < 3; ++i) force.F[i] = F_hand[i] * (most / std::sqrt(squared_force));
      std::fill_n(force.response, 3, 0.0);
      evaluate(dt);
      advance(dt);
    }
    cell = {Vec3::Map(arm_on_hand), Vec3::Map(arm_on_hand + 4)};
    to_end(dt, joints, lanes(q_mid), lanes(friction.v()), lanes(v), lanes(v_before), lanes(q));
    t += dt;
    encoders.step(lanes(q), dt);
    sense();
  }

  [[nodiscard]] double energy() noexcept {
    const arm::Dynamics& now = arm.dynamics(q, v);
    const Vec6 V = now.J * v;
    const double kinetic = v.dot(now.M * v) + v.dot(options.rotor_inertia.cwiseProduct(v)) +
                           hand.mass * V.head<3>().squaredNorm() + hand.inertia * V.tail<3>().squaredNorm();
    return 0.5 * kinetic + arm.potential_energy(q) + arm.elastic_energy(q);
  }

  arm::Arm arm;
  LeaderOptions options;
  HandOptions hand;
  Drive drive;
  Encoders encoders;
  DryFriction friction;
  HandLanes impedance;  // of the hand
  HandForce force;
  LeaderJoints joints;
  LeaderLoads loads;
  alignas(64) HandleLanes V_handle, F_push, F_hand, arm_on_hand;
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
