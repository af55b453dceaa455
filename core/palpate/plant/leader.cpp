#include "palpate/plant/leader.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>
#include <sstream>
#include <stdexcept>

#include "palpate/plant/drive.hpp"
#include "palpate/plant/dry_friction.hpp"
#include "palpate/plant/encoders.hpp"
#include "palpate/types/random.hpp"

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

/// Rotation vector that turns R_from into R_to, in the axes both are expressed in.
Vec3 turn_between(const Mat3& R_from, const Mat3& R_to) noexcept {
  const Eigen::AngleAxisd turn(R_to * R_from.transpose());
  return turn.angle() * turn.axis();
}

}  // namespace

// The step, with h = dt, q' = q + h/2 v the middle of it, and everything evaluated there:
//   (M + I_r + J^T M_h J) (v+ - v) = h (tau - C v - G - E - D v+ + J^T (F_hand+ - M_h dJ v)) + friction + stops
//   F_hand+ = K (x_path - x' - h/2 J v+) + B (xdot_path - J v+)         spring and damper at the END of the step
//   q+ = q' + h/2 v+
// E: the counterbalance. Stiff hands and light wrists are stable because v+ stands on both sides; without friction and
// damping the middle point makes the step second order, so that a free swing keeps its energy.
struct Leader::Impl {
  /// The six rows of a Jacobian as plain arrays, zero beyond the last joint: loops over them have fixed bounds.
  struct JacobianRows {
    alignas(64) double row[6][kMaxJoints] = {};

    void take(const Jacobian& J) noexcept {
      for (Eigen::Index k = 0; k < J.cols(); ++k) {
        for (int r = 0; r < 6; ++r) row[r][k] = J(r, k);
      }
    }
    /// J v
    [[nodiscard]] Vec6 operator*(const JointVector& v) const noexcept {
      Vec6 V;
      for (int r = 0; r < 6; ++r) {
        double sum = 0.0;
        for (Eigen::Index k = 0; k < v.size(); ++k) sum += row[r][k] * v[k];
        V[r] = sum;
      }
      return V;
    }
  };

  Impl(arm::Arm a, LeaderOptions o, HandOptions h)
      : arm(std::move(a)),
        options(std::move(o)),
        hand(h),
        drive({options.loop_delay, options.loop_jitter, options.drive_lag, options.hold_timeout, options.tau_max,
               options.seed}),
        encoders({options.coupling, options.encoder_step, options.velocity_window, options.velocity_cutoff}),
        random(options.seed) {
    grip(hand);
  }

  void grip(const HandOptions& h) noexcept {
    hand = h;
    M_hand << Vec3::Constant(hand.mass), Vec3::Constant(hand.inertia);
    K << Vec3::Constant(hand.stiffness), Vec3::Constant(hand.rotational_stiffness);
    B << Vec3::Constant(hand.damping), Vec3::Constant(hand.rotational_damping);
  }

  void place(const JointVector& q0) noexcept {
    q = q0.cwiseMax(arm.q_min()).cwiseMin(arm.q_max());
    v = v_before = b = JointVector::Zero(q.size());
    A = JointMatrix::Zero(q.size(), q.size());
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
    state.q = options.quantised ? encoders.q() : q;
    state.v = options.quantised ? encoders.v() : v;
    state.gripper = gripper;
    state.valid = true;
    state.F_cell_L = cell.f;
    state.has_load_cell = true;
    if (options.cell_noise > 0.0) state.F_cell_L += options.cell_noise * Vec3(gauss(), gauss(), gauss());
  }

  /// Normal, of unit variance (the sum of twelve uniforms; the same on every machine).
  double gauss() noexcept {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += uniform(random);
    return sum;
  }

  /// Bounds of the friction impulse; at an end stop the stop adds whatever it takes.
  void bound_friction(double dt) noexcept {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    hi = dt * options.coulomb;
    lo = -hi;
    for (Eigen::Index k = 0; k < q_mid.size(); ++k) {
      if (q_mid[k] <= arm.q_min()[k]) hi[k] = kInfinity;
      if (q_mid[k] >= arm.q_max()[k]) lo[k] = -kInfinity;
    }
  }

  /// Velocity at the end of the step when the hand pushes with F + (its own answer to v+, `response` per velocity).
  const JointVector& advance(const arm::Dynamics& d, const JointVector& tau, const Vec6& F, const Vec6& response,
                             double dt) noexcept {
    const Vec6 H = M_hand + dt * response;
    const Vec6 push = M_hand.cwiseProduct(J * v - dt * d.Jdot_v) + dt * (F + F_push);
    for (Eigen::Index j = 0; j < v.size(); ++j) {  // by hand: Eigen takes its large-matrix path for 7 x 6 x 7
      double column[kMaxJoints] = {}, pushed = 0.0, momentum = 0.0;
      for (int r = 0; r < 6; ++r) {
        const double HJ = H[r] * J.row[r][j];
        for (int i = 0; i < kMaxJoints; ++i) column[i] += HJ * J.row[r][i];
        pushed += J.row[r][j] * push[r];
      }
      for (Eigen::Index i = 0; i < v.size(); ++i) {
        A(i, j) = d.M(i, j) + column[i];
        momentum += d.M(i, j) * v[i];
      }
      b[j] = momentum + pushed;
    }
    A.diagonal() += options.rotor_inertia + dt * options.viscous;
    b += options.rotor_inertia.cwiseProduct(v) + dt * (tau - d.bias - arm.elastic(q_mid));
    return friction.solve(A, b, lo, hi);
  }

  void step(double dt, const Pose& X_path, const Twist& V_path, const Wrench& push) noexcept {
    F_push << push.f, push.t;
    const JointVector& tau = drive.step(dt);
    q_mid = q + 0.5 * dt * v;
    const arm::Dynamics& d = arm.dynamics(q_mid, 1.5 * v - 0.5 * v_before);
    J.take(d.J);
    bound_friction(dt);

    Vec6 x_error, V;
    x_error << X_path.p - d.X_0T.p, turn_between(d.X_0T.R, X_path.R);
    V << V_path.v, V_path.w;
    const Vec6 F0 = K.cwiseProduct(x_error) + B.cwiseProduct(V);
    const Vec6 response = 0.5 * dt * K + B;
    v_next = advance(d, tau, F0, response, dt);
    Vec6 F = F0 - response.cwiseProduct(J * v_next);
    const double grip = F.head<3>().norm();
    slipped = grip > hand.grip_force_max;
    if (slipped) {  // the fingers slide: the force is what they can hold, whatever the velocity
      Vec6 F_slip = F0, response_slip = response;
      F_slip.head<3>() = F.head<3>() * (hand.grip_force_max / grip);
      response_slip.head<3>().setZero();
      v_next = advance(d, tau, F_slip, response_slip, dt);
      F = F_slip - response_slip.cwiseProduct(J * v_next);
    }
    // Newton on the hand's mass: what the arm does to it is what it does, less what the person does.
    const Vec6 arm_on_hand = M_hand.cwiseProduct((J * JointVector(v_next - v)) / dt + d.Jdot_v) - F - F_push;
    cell = {arm_on_hand.head<3>(), arm_on_hand.tail<3>()};

    q = (q_mid + 0.5 * dt * v_next).cwiseMax(arm.q_min()).cwiseMin(arm.q_max());
    v_before = v;
    v = v_next;
    t += dt;
    encoders.step(q, dt);
    measure();
  }

  [[nodiscard]] double energy() noexcept {
    const arm::Dynamics& d = arm.dynamics(q, v);
    const Vec6 V = d.J * v;
    const double kinetic =
        v.dot(d.M * v) + v.dot(options.rotor_inertia.cwiseProduct(v)) + V.dot(M_hand.cwiseProduct(V));
    return 0.5 * kinetic + arm.potential_energy(q) + arm.elastic_energy(q);
  }

  arm::Arm arm;
  LeaderOptions options;
  HandOptions hand;
  Drive drive;
  Encoders encoders;
  DryFriction friction;
  Vec6 M_hand, K, B;  // of the hand: linear over angular
  Vec6 F_push;
  JointVector q, v, v_before, v_next, q_mid, b, lo, hi;
  JointMatrix A;
  JacobianRows J;
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
