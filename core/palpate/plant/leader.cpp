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
#include "palpate/types/pack.hpp"
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

using Six = double[6];
Six& as_array(Vec6& x) noexcept { return *reinterpret_cast<Six*>(x.data()); }
const Six& as_array(const Vec6& x) noexcept { return *reinterpret_cast<const Six*>(x.data()); }

}  // namespace

/// Middle of the step, and the velocity extrapolated to it.
PALPATE_AVX2_TOO void to_middle(double dt, const Lanes& q, const Lanes& v, const Lanes& v_before, Lanes& q_mid,
                                Lanes& v_mid) noexcept {
  store(load(q) + 0.5 * dt * load(v), q_mid);
  store(1.5 * load(v) - 0.5 * load(v_before), v_mid);
}

/// V <- J x, of the rows of J.
PALPATE_AVX2_TOO void multiply_rows(const Lanes (&J)[6], const Lanes& x, Six& V) noexcept {
  for (int r = 0; r < 6; ++r) V[r] = dot(load(J[r]), load(x));
}

/// Equation A v = b of the velocity at the end of the step: inertia of arm and hand, and their momentum after all
/// impulses but friction. H: inertia of the hand and of its answer to v; push: impulse on the handle; tau: sum of the
/// joint torques.
PALPATE_AVX2_TOO void assemble(const arm::LaneDynamics& d, const Lanes& rotor, const Lanes& viscous, double dt,
                               const Six& H, const Six& push, const Lanes& tau, const Lanes& v, Lanes (&A)[kLanes],
                               Lanes& b) noexcept {
  Pack of_motion = load(rotor) * load(v), of_push = dt * load(tau);
  for (int j = 0; j < kLanes; ++j) of_motion = of_motion + v[j] * load(d.M[j]);
  for (int r = 0; r < 6; ++r) of_push = of_push + push[r] * load(d.J[r]);
  store(of_motion + of_push, b);
  Lanes HJ[6];
  for (int r = 0; r < 6; ++r) store(H[r] * load(d.J[r]), HJ[r]);
  for (int j = 0; j < kLanes; ++j) {
    Pack row = load(d.M[j]);
    for (int r = 0; r < 6; ++r) row = row + HJ[r][j] * load(d.J[r]);
    store(row, A[j]);
    A[j][j] += rotor[j] + dt * viscous[j];
  }
}

/// End of the step, within the limits.
PALPATE_AVX2_TOO void to_end(double dt, const Lanes& q_mid, const Lanes& v, const Lanes& q_min, const Lanes& q_max,
                             Lanes& q) noexcept {
  store(min(max(load(q_mid) + 0.5 * dt * load(v), load(q_min)), load(q_max)), q);
}

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
    measure();
  }

  void measure() noexcept {
    state.t = t;
    copy(options.quantised ? encoders.q() : q, state.q);
    copy(options.quantised ? encoders.v() : v, state.v);
    state.gripper = gripper;
    state.valid = true;
    state.F_cell_L = cell.f;
    state.has_load_cell = true;
    if (options.cell_noise > 0.0) state.F_cell_L += options.cell_noise * Vec3(gauss(), gauss(), gauss());
  }

  /// A normal random number of unit variance, as the sum of twelve uniform ones: the same on every machine.
  double gauss() noexcept {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform(random);
    return sum;
  }

  /// Bounds of the friction impulse. At an end stop the impulse of the stop has no bound.
  void bound_friction(double dt) noexcept {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    for (int k = 0; k < kLanes; ++k) {
      hi[k] = dt * joints.coulomb[k];
      lo[k] = -hi[k];
    }
    for (int k = 0; k < q.size(); ++k) {
      if (q_mid.data()[k] <= joints.q_min[k]) hi[k] = kInfinity;
      if (q_mid.data()[k] >= joints.q_max[k]) lo[k] = -kInfinity;
    }
  }

  /// Velocity at the end of the step if the hand pushes with F - response * (velocity of the handle at that end).
  const Lanes& advance(const Vec6& F, const Vec6& response, const Vec6& V_handle, double dt) noexcept {
    const Vec6 H = M_hand + dt * response;
    const Vec6 push = M_hand.cwiseProduct(V_handle - dt * d.Jdot_v) + dt * (F + F_push);
    alignas(64) Lanes A[kLanes], b;
    assemble(d, joints.rotor, joints.viscous, dt, as_array(H), as_array(push), tau, lanes(v), A, b);
    return lanes(friction.solve(A, b, lo, hi));
  }

  void step(double dt, const Pose& X_path, const Twist& V_path, const Wrench& push) noexcept {
    F_push << push.f, push.t;
    const Lanes& tau_drives = lanes(drive.step(dt));
    to_middle(dt, lanes(q), lanes(v), lanes(v_before), lanes(q_mid), lanes(v_mid));
    arm.lane_dynamics(q_mid, v_mid, d);
    const JointVector elastic = arm.elastic(q_mid);
    for (int k = 0; k < kLanes; ++k) tau[k] = tau_drives[k] - d.bias[k] - (k < q.size() ? elastic.data()[k] : 0.0);
    bound_friction(dt);

    Vec6 x_error, V;
    x_error << X_path.p - d.X_0T.p, turn_between(d.X_0T.R, X_path.R);
    V << V_path.v, V_path.w;
    const Vec6 F0 = K.cwiseProduct(x_error) + B.cwiseProduct(V);
    const Vec6 response = 0.5 * dt * K + B;
    Vec6 V_before, dV;  // velocity of the handle; its change
    multiply_rows(d.J, lanes(v), as_array(V_before));
    const auto push_with = [&](const Vec6& force, const Vec6& answer) {
      const Lanes& v_next = advance(force, answer, V_before, dt);
      alignas(64) Lanes dv;
      for (int k = 0; k < kLanes; ++k) dv[k] = v_next[k] - lanes(v)[k];
      multiply_rows(d.J, dv, as_array(dV));
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
    const Vec6 arm_on_hand = M_hand.cwiseProduct(dV / dt + d.Jdot_v) - F - F_push;
    cell = {arm_on_hand.head<3>(), arm_on_hand.tail<3>()};

    std::copy_n(lanes(v), kLanes, lanes(v_before));
    std::copy_n(lanes(friction.v()), kLanes, lanes(v));
    to_end(dt, lanes(q_mid), lanes(v), joints.q_min, joints.q_max, lanes(q));
    t += dt;
    encoders.step(lanes(q), dt);
    measure();
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
  struct alignas(64) Joints {
    Lanes coulomb, viscous, rotor;  // as LeaderOptions, zero beyond the last joint
    Lanes q_min, q_max;             // [rad]
  } joints;
  JointVector q, v, v_before, q_mid, v_mid;  // zero beyond the last joint
  arm::LaneDynamics d;                       // at the middle of the step
  alignas(64) Lanes tau, lo, hi;             // torques of drives, weight, motion and spring; bounds of the friction
  LeaderState state;
  Wrench cell;
  double gripper = 0.0, t = 0.0;
  bool slipped = false;
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

const LeaderState& Leader::measured() const noexcept { return impl_->state; }
const JointVector& Leader::q() const noexcept { return impl_->q; }
const JointVector& Leader::v() const noexcept { return impl_->v; }
const Wrench& Leader::load_cell() const noexcept { return impl_->cell; }
bool Leader::hand_slipped() const noexcept { return impl_->slipped; }
double Leader::energy() const noexcept { return impl_->energy(); }

}  // namespace palpate::plant
