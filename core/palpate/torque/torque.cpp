#include "palpate/torque/torque.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "palpate/torque/cartesian.hpp"
#include "palpate/types/require.hpp"
#include "palpate/types/status.hpp"

namespace palpate::torque {
namespace {

constexpr Eigen::Index kPositioning = 3;  // number of joints that position the wrist centre (section 2.3)
constexpr Eigen::Index kPlatform = 3;     // index of joint 4
constexpr Eigen::Index kMtmJoints = 7;
constexpr double kMaxInertia = 20.0;  // [kg] a direction with more inertia at the handle counts as singular
constexpr double kCapArm = 0.1;       // [m] lever arm that converts law_cap into a cap of moments
constexpr double kHandMotion = 10.0;  // [Hz] cutoff frequency of the handle's acceleration: faster motion is noise
constexpr double kRounding = 1e-12;   // [N m] excess over the drive limit that is neglected
constexpr double kFade = 0.06;  // [s] time constant with which the wrench of the law fades when the leader is stale

void check(const Options& o, Eigen::Index n) {
  require("torque", o.platform_gain >= 0.0 && o.platform_gain <= 1.0, "platform_gain", o.platform_gain,
          "must lie in 0..1");
  require("torque", o.force_gain >= 0.0 && o.force_gain <= 1.0, "force_gain", o.force_gain, "must lie in 0..1");
  require("torque", o.gravity_gain >= 0.0, "gravity_gain", o.gravity_gain, "must be 0 or more");
  require("torque", o.friction.gain >= 0.0 && o.friction.gain <= 1.0, "friction_gain", o.friction.gain,
          "must lie in 0..1: more than the friction would drive the arm");
  require("torque", o.friction.dead_band > 0.0 && o.friction.full_speed > o.friction.dead_band, "friction_dead_band",
          o.friction.dead_band, "must be above 0 and below friction_full_speed [rad/s]");
  require("torque", o.limits.gain >= 0.0 && o.limits.gain <= 1.0, "limit_gain", o.limits.gain, "must lie in 0..1");
  require("torque", o.limits.margin > 0.0 && o.limits.margin <= 0.5, "limit_margin", o.limits.margin,
          "must lie in 0..0.5");
  require("torque", o.law_cap >= 0.0 && std::isfinite(o.law_cap), "law_cap", o.law_cap,
          "must be 0 N or more, and finite");
  require("torque", o.fast_force > 0.0, "fast_force", o.fast_force, "must be above 0 N");
  for (const JointVector* x : {&o.friction.coulomb, &o.friction.viscous, &o.rotor_inertia}) {
    if (x->size() != n || !(x->array() >= 0.0).all()) {
      throw std::invalid_argument("the torque stage's coulomb, viscous and rotor_inertia need " + std::to_string(n) +
                                  " entries of zero or more, one per joint, or none; got " + std::to_string(x->size()));
    }
  }
}

/// Largest factor on tau_force, at most 1, for which tau_hold + factor * tau_force is within the drive limits.
double saturation_factor(const JointVector& tau_force, const JointVector& tau_hold, const JointVector& limit) noexcept {
  double factor = 1.0;
  for (Eigen::Index k = 0; k < limit.size(); ++k) {
    const double room = limit[k] - std::copysign(1.0, tau_force[k]) * tau_hold[k];
    const double requested = std::abs(tau_force[k]);
    if (requested > room + kRounding) factor = std::min(factor, std::max(room, 0.0) / requested);
  }
  return factor;
}

}  // namespace

double removed_friction(const Options& options, double dt) {
  return make_control_law(options.law, options.laws, dt)->removes_friction() ? 1.0 : options.friction.gain;
}

Torque::Torque(Options options, JointVector tau_max, double dt)
    : options_(std::move(options)), tau_max_(std::move(tau_max)), dt_(dt) {
  if (!(tau_max_.array() > 0.0).all()) {
    throw std::invalid_argument("every drive limit tau_max must be above zero; give the arm's URDF effort limits");
  }
  for (JointVector* x : {&options_.friction.coulomb, &options_.friction.viscous, &options_.rotor_inertia}) {
    if (x->size() == 0) *x = JointVector::Zero(tau_max_.size());
  }
  check(options_, tau_max_.size());
  law_ = make_control_law(options_.law, options_.laws, dt);
}

unsigned Torque::step(arm::Arm& model, const Input& in, LeaderCommand& out) noexcept {
  const Eigen::Index n = tau_max_.size();
  const bool full = options_.mode == Mode::full;
  const JointVector &q = in.leader.q, &v = in.leader.v;
  const unsigned status = step_law(model, in, out);
  out.tau_gravity = options_.gravity_gain * model.holding(q, model.state().G);
  out.tau_limits = limits(options_.limits, q, model.q_min(), model.q_max(), tau_max_);
  out.tau_friction = friction(options_.friction, v);
  out.tau_platform.setZero(n);
  if (full && n == kMtmJoints) out.tau_platform[kPlatform] = platform(options_.platform_gain, q, v);
  if (!full && n > kPositioning) {
    for (JointVector* tau : {&out.tau_gravity, &out.tau_limits, &out.tau_friction}) {
      tau->tail(n - kPositioning).setZero();
    }
  }
  return status | (saturate(in, model.jacobian(), out) ? kTorqueLimited : 0u);
}

bool Torque::renders_damping(const LeaderState& leader) const noexcept {
  return law_->renders_damping() && leader.has_load_cell && leader.F_cell_L.allFinite();
}

// Computes the wrench that the law adds to the rendered force, and checks that the law is valid for the present motion.
unsigned Torque::step_law(arm::Arm& model, const Input& in, LeaderCommand& out) noexcept {
  const bool full = options_.mode == Mode::full;
  if (!in.fresh) {
    law_->reset();
    started_ = false;
    out.F_law_L.f *= std::max(0.0, 1.0 - dt_ / kFade);
    out.F_law_L.t.setZero();
    out.F_neglected = 0.0;
    return 0u;
  }
  const LeaderState& leader = in.leader;
  const arm::Dynamics& d = model.state();
  const Eigen::Index n = tau_max_.size();
  const bool cell_valid = leader.has_load_cell && leader.F_cell_L.allFinite();
  ControlLawInput law_input;
  bool singular = false;
  // In mode `paper` the hand holds the wrist: only the position counts, as for an arm that cannot orient its tip.
  if (full && model.orients()) {
    const Cartesian<6> c = cartesian<6>(d, options_.rotor_inertia, n, kMaxInertia);
    law_input.Lambda = c.Lambda.leftCols<3>();
    law_input.Gamma_v = {c.Gamma_v.head<3>(), c.Gamma_v.tail<3>()};
    singular = c.singular;
  } else {
    const Cartesian<3> c = cartesian<3>(d, options_.rotor_inertia, full ? n : std::min(kPositioning, n), kMaxInertia);
    law_input.Lambda << c.Lambda, Mat3::Zero();
    law_input.Gamma_v.f = c.Gamma_v;
    singular = c.singular;
  }
  const Vec3 v_LH = model.twist().v;
  law_input.p_LH = model.tip().p;
  law_input.v_LH = v_LH;
  law_input.F_H_L = in.on_hand.F.f;
  law_input.B_L = in.on_hand.B;
  law_input.F_hand_L = cell_valid ? Vec3(-leader.F_cell_L) : Vec3::Zero();
  if (!started_) v_filtered_ = v_LH;
  started_ = true;
  const double w = 2.0 * std::numbers::pi * kHandMotion;
  const Vec3 a = w / (1.0 + w * dt_) * (v_LH - v_filtered_);
  v_filtered_ += dt_ * a;
  out.F_neglected = law_->neglected_force(law_input, a).norm();
  const bool too_fast = out.F_neglected > options_.fast_force;
  const unsigned status = (singular ? kSingular : 0u) | (too_fast ? kTooFast : 0u);
  out.F_law_L = {};
  if (law_->needs_load_cell() && !cell_valid) {
    law_->reset();
    return status | kNoLoadCell;
  }
  const Wrench add = law_->step(law_input);
  if (add.f.allFinite() && add.t.allFinite()) {
    const double size = std::max(add.f.norm(), add.t.norm() / kCapArm);
    const double factor = size > options_.law_cap ? options_.law_cap / size : 1.0;
    out.F_law_L = {factor * add.f, factor * add.t};
  }
  return status;
}

// Scales the torques to the drive limits. Returns true if a limit was reached.
bool Torque::saturate(const Input& in, const Jacobian& J, LeaderCommand& out) noexcept {
  // The torques that hold the arm come first: it must not fall because a force or the platform term needs torque.
  JointVector tau_allotted = JointVector::Zero(tau_max_.size());
  bool limited = false;
  for (JointVector* tau : {&out.tau_gravity, &out.tau_limits, &out.tau_platform, &out.tau_friction}) {
    const JointVector requested = tau_allotted + *tau;
    const JointVector next = requested.cwiseMax(-tau_max_).cwiseMin(tau_max_);
    limited |= next != requested;
    if (next != requested) *tau = next - tau_allotted;
    tau_allotted = next;
  }
  // One factor scales the force at all joints, so that its direction stays the same. The moments use the remaining
  // torque.
  const bool full = options_.mode == Mode::full;
  const Eigen::Index n = tau_max_.size(), joints = full ? n : std::min(kPositioning, n);
  const double gain = options_.force_gain;
  JointVector tau_f = JointVector::Zero(n), tau_t = tau_f;
  tau_f.head(joints).noalias() = gain * (J.topLeftCorner(3, joints).transpose() * (in.on_hand.F.f + out.F_law_L.f));
  if (full) tau_t.noalias() = gain * (J.bottomRows<3>().transpose() * (in.on_hand.F.t + out.F_law_L.t));
  const double factor_f = saturation_factor(tau_f, tau_allotted, tau_max_);
  tau_allotted += factor_f * tau_f;
  const double factor_t = saturation_factor(tau_t, tau_allotted, tau_max_);
  out.tau_force = factor_f * tau_f + factor_t * tau_t;
  out.F_H_L = {gain * factor_f * in.on_hand.F.f, (full ? gain * factor_t : 0.0) * in.on_hand.F.t};
  return limited || factor_f < 1.0 || factor_t < 1.0;
}

}  // namespace palpate::torque
