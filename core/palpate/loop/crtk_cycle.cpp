#include "palpate/loop/crtk_cycle.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "palpate/loop/record.hpp"
#include "palpate/types/low_pass.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::loop {
namespace {

constexpr double kSettled = 0.5;         // [s] time after which a follower has reached the goal that it holds
constexpr double kHeldLag = 0.002;       // [m] then: largest distance from this goal, beyond which others moved it
constexpr double kHeldTurn = 0.05;       // [rad] then: largest rotation from this goal
constexpr double kRounded = 1.0 + 1e-6;  // factor on a limit, so that rounding errors do not exceed it
constexpr double kTwistCutoff = 40.0;    // [Hz] of the low-pass for the velocity of the instrument that others see
/// Bits that are states of operation, not faults.
constexpr std::uint64_t kGates = kNoOperator | kNotEnabled | kNotFollowing | kClutched;

/// F shortened to the length `most` if it is longer.
Vec3 within(const Vec3& F, double most) noexcept {
  const double norm = F.norm();
  return norm > most ? Vec3(most / norm * F) : F;
}

CrtkOptions checked(CrtkOptions o, const std::optional<arm::Arm>& follower) {
  const auto refuse = [](const std::string& words) { throw std::invalid_argument("crtk: " + words); };
  if (o.source != force::Source::contact)
    refuse("CRTK does not report the follower's torques, so no force can be estimated from them; use contact");
  if (o.virtual_follower && !(follower && o.q_follower0.size() == follower->n())) {
    refuse("a virtual follower needs its arm and q_follower0, one number per joint");
  }
  for (const contact::ToolSphere& sphere : o.contact.spheres) {
    const int links = follower ? static_cast<int>(follower->link_names().size()) : 0;
    if (sphere.link >= links) {
      refuse("a sphere sits on link " + std::to_string(sphere.link) + ", the follower's model has " +
             std::to_string(links) + " links");
    }
  }
  for (const double& x : {o.release, o.settle, o.max_lag, o.max_period_ratio, o.watch.stale_after}) {
    if (!(x > 0.0 && std::isfinite(x))) refuse("release, settle, lag_most, slowest and stale_after must be above 0");
  }
  o.stability.stale_after = std::numeric_limits<double>::infinity();  // Watch judges the age of states, by two clocks
  return o;
}

}  // namespace

CrtkCycle::CrtkCycle(const CrtkOptions& options, std::optional<arm::Arm> follower)
    : options_(checked(options, follower)),
      arm_(std::move(follower)),
      haptics_(options_),
      leader_(options.watch),
      follower_(options.watch),
      joints_(options.watch),
      velocity_(options.watch) {
  if (arm_) {
    zero_ = JointVector::Zero(arm_->n());
    q_step_ = arm_->v_max() / options_.rate;
    q_follower_ = options_.virtual_follower ? options_.q_follower0 : zero_;
    arm_->update(q_follower_, zero_);
    if (options_.virtual_follower && arm_) X_BT_ = arm_->tip();
  }
  in_.tool.jaw = options_.mapping.jaw_start;
}

void CrtkCycle::leader_pose(double stamp, const Vec3& p_LH, const Eigen::Vector4d& quat_LH, ClockTime now) noexcept {
  const Pose last = in_.handle.X_LH;
  const bool known = leader_.received();
  if (!leader_.stamp(stamp, now) || !leader_.pose(p_LH, quat_LH, in_.handle.X_LH)) return;
  if (const double dt = leader_.interval(); known && dt > 0.0) velocity_.moved(last, in_.handle.X_LH, dt, now);
}

void CrtkCycle::leader_twist(double stamp, const Twist& V_LH, ClockTime now) noexcept {
  velocity_.reported(stamp, V_LH, now);
}

void CrtkCycle::leader_joints(double stamp, const double* q, std::size_t n) noexcept {
  if (!(stamp > 0.0) || n == 0 || n > kMaxJoints) return;  // the joints serve the friction estimate only: no fault
  const auto joints = Eigen::Map<const Eigen::VectorXd>(q, static_cast<Eigen::Index>(n));
  if (joints.allFinite()) in_.handle.q = joints;
}

void CrtkCycle::gripper(double stamp, const double* angle, std::size_t n) noexcept {
  if (!(stamp > 0.0)) return;
  if (n == 1 && std::abs(angle[0]) < 10.0) {
    in_.handle.gripper = angle[0];
  } else {
    refuse(kNotFinite);
  }
}

void CrtkCycle::jaw(double stamp, const double* angle, std::size_t n) noexcept {
  if (options_.virtual_follower || !(stamp > 0.0)) return;
  if (n == 1 && std::abs(angle[0]) < 10.0) {
    in_.tool.jaw = angle[0];
  } else {
    refuse(kNotFinite);
  }
}

void CrtkCycle::follower_pose(double stamp, const Vec3& p_BT, const Eigen::Vector4d& quat_BT, ClockTime now) noexcept {
  if (options_.virtual_follower) return;
  if (follower_.stamp(stamp, now)) follower_.pose(p_BT, quat_BT, X_BT_);
}

void CrtkCycle::follower_joints(double stamp, const double* q, std::size_t n, ClockTime now) noexcept {
  if (options_.virtual_follower || !arm_ || !joints_.stamp(stamp, now)) return;
  const auto joints = Eigen::Map<const Eigen::VectorXd>(q, static_cast<Eigen::Index>(n));
  if (n == static_cast<std::size_t>(arm_->n()) && (joints.array().abs() < 1e6).all()) {
    q_follower_ = joints;
  } else {
    joints_.refuse(kNotFinite);
  }
}

void CrtkCycle::set_scale(double scale) noexcept {
  if (!(scale > 0.0 && scale <= 10.0)) {
    refuse(kNotFinite);
  } else if (scale != haptics_.mapping().options().scale) {
    haptics_.rescale(scale);
  }
}

const CrtkOutput& CrtkCycle::step(ClockTime now) noexcept {
  const double dt = stepped_ ? std::max(now.t - last_.t, 0.0) : 0.0;
  out_.tick = Tick{};
  const std::uint64_t status = check_conditions(now);
  last_ = now;
  stepped_ = true;
  if (in_.scene == nullptr) return out_;

  const bool trusted = (status & ~kGates) == 0;
  if (trusted && needs_reset_) {
    haptics_.forget_contacts();
    needs_reset_ = false;
  }
  in_.t = now.t;
  in_.handle.t = in_.tool.t = now.t;
  in_.handle.valid = in_.tool.valid = trusted;
  const Controls people = in_.controls;
  in_.controls.following = people.following && (status & kNotFollowing) == 0;
  in_.controls.operator_present = people.operator_present && (status & kNoOperator) == 0;
  in_.controls.camera = people.camera || gates_.camera;
  in_.homed = (status & kNotEnabled) == 0;
  in_.settling = (status & ~kGates) == kSettling;
  in_.controls.clutch = people.clutch || gates_.clutch;
  locate();
  meet(trusted);
  const HapticsOutput& felt = haptics_.step(in_);
  F_ = released(felt.rendered.F_H_L, felt.mapped.engaged, dt);
  haptics_.finish(in_, F_ - felt.rendered.on_hand.damping(in_.handle.V_LH.v), out_.tick);  // finish() adds it
  const unsigned reached = follow(felt);
  in_.controls = people;

  const Mat3& R_LH = in_.handle.X_LH.R;
  out_.F = options_.tip_frame ? Wrench{R_LH.transpose() * F_.f, R_LH.transpose() * F_.t} : F_;
  // A device keeps the last wrench it received. After a wrench that was not zero, commands therefore continue down to
  // zero, even if commanding is no longer allowed.
  const bool ours = (gates_.leader_enabled || !options_.needs_state) && !gates_.other_teleop;
  out_.command = (ours && (status & kNoOperator) == 0) || last_nonzero_;
  last_nonzero_ = out_.command && !(F_.f.isZero(0.0) && F_.t.isZero(0.0));
  out_.tick.t = now.t;
  const unsigned caps = felt.rendered.status & ~(kLeaderStale | kFollowerStale);
  out_.tick.status |= status | caps | reached;  // adds to the bits that guidance reported
  if (in_world_ || body_port_) on_tool_.record(out_.tick);
  copy(in_.handle.q, out_.tick.q);
  if (arm_) copy(q_follower_, out_.tick.q_follower);
  return out_;
}

void CrtkCycle::reset_wrench() noexcept {
  F_ = {};
  fault_at_ = last_.t;
  needs_reset_ = true;
}

// Everything that forbids a force now, as bits of Status. Bits outside kGates are faults: after a fault the force stays
// zero until no fault has occurred for the time `settle`.
std::uint64_t CrtkCycle::check_conditions(ClockTime now) noexcept {
  std::uint64_t fault = take_message_faults(now) | motion_faults(now) | gate_faults();
  if (gates_.two_sources) fault = gate_faults();  // which of the sources sent what is not known
  if (const Cause& cause = faults_.cause; (cause.bit & fault) != 0) {
    out_.tick.cause[0] = std::countr_zero(cause.bit);
    out_.tick.cause[1] = cause.value;
    out_.tick.cause[2] = cause.other;
  }
  faults_ = {};
  if (fault != 0) {
    fault_at_ = now.t;
    needs_reset_ = true;
  } else if (needs_reset_ && now.t - fault_at_ < options_.settle) {
    fault = kSettling;
  }
  return fault | closed_gates();
}

// Faults of the messages since the last step, which are cleared: damaged or missing messages, or too few of them.
std::uint64_t CrtkCycle::take_message_faults(ClockTime now) noexcept {
  add(leader_.take_faults());
  add(velocity_.take_faults());
  add(follower_.take_faults());
  add(joints_.take_faults());
  if (leader_.period() * options_.rate > kRounded * options_.max_period_ratio) {
    refuse(kSlow, 1.0 / leader_.period(), options_.rate / options_.max_period_ratio);
  }
  if (leader_.stale(now)) refuse(kLeaderStale, leader_.silence(now), options_.watch.stale_after);
  if (!options_.virtual_follower && follower_.stale(now)) {
    refuse(kFollowerStale, follower_.silence(now), options_.watch.stale_after);
  }
  return faults_.bits;
}

// Faults of time and motion: a cycle that has paused, or a follower that is too far from its goal.
std::uint64_t CrtkCycle::motion_faults(ClockTime now) noexcept {
  const double passed = now.t - last_.t, lag = (out_.X_BT_goal.p - X_BT_.p).norm();
  if (stepped_ && passed > options_.watch.stale_after) refuse(kStalled, passed, options_.watch.stale_after);
  if (options_.own_teleop && !options_.virtual_follower && in_.tool.valid && out_.move && lag > options_.max_lag) {
    refuse(kLagging, lag, options_.max_lag);
  }
  return faults_.bits;
}

// Keeps the cause of the first fault of this tick.
void CrtkCycle::add(const Faults& more) noexcept {
  if (faults_.bits == 0) faults_.cause = more.cause;
  faults_.bits |= more.bits;
}

void CrtkCycle::refuse(std::uint64_t bit, double value, double other) noexcept { add({bit, {bit, value, other}}); }

// Faults that the console and the ROS graph report.
std::uint64_t CrtkCycle::gate_faults() const noexcept {
  const CrtkGates& g = gates_;
  return (g.second_writer ? kSecondWriter : 0u) | (g.other_teleop ? kOtherTeleop : 0u) | (g.guarded ? kGuarded : 0u) |
         (g.frame_unsure ? kFrameUnsure : 0u) | (g.two_sources ? +kTwoSources : 0u) |
         (g.no_listener ? +kNoListener : 0u) | (g.base_moved ? +kBaseMoved : 0u);
}

// Conditions in kGates: nothing is wrong, but the operator or the arms do not allow a force now.
std::uint64_t CrtkCycle::closed_gates() const noexcept {
  const CrtkGates& g = gates_;
  const bool enabled = !options_.needs_state || (g.leader_enabled && (options_.virtual_follower || g.follower_enabled));
  const bool nobody = options_.own_teleop && options_.needs_operator && !g.operator_present;
  return (enabled ? 0u : kNotEnabled) | (nobody ? kNoOperator : 0u) | (g.following ? 0u : kNotFollowing) |
         (g.clutch || in_.controls.clutch ? kClutched : 0u);
}

// Updates the pose of the tool, the velocity of the handle and the spheres.
void CrtkCycle::locate() noexcept {
  in_.handle.V_LH = in_.handle.valid ? velocity_.value(last_) : Twist{};
  if (arm_) arm_->update(q_follower_, zero_);
  if (options_.virtual_follower && arm_) X_BT_ = arm_->tip();
  in_.tool.X_WT = options_.X_WB * X_BT_;
  place_spheres(joints_known());
}

bool CrtkCycle::joints_known() const noexcept {
  return arm_ && (options_.virtual_follower || (joints_.received() && !joints_.stale(last_)));
}

// Pose of the model's base in W that agrees with the measured tip.
Pose CrtkCycle::model_base(const arm::Arm& arm) const noexcept { return in_.tool.X_WT * arm.tip().inverse(); }

void CrtkCycle::join(std::shared_ptr<Board> board, int index, std::vector<ToolCapsule> capsules,
                     contact::InstrumentLaw law) {
  if (!arm_) throw std::invalid_argument("crtk: instruments that push each other need a model of the follower");
  const int links = static_cast<int>(arm_->link_names().size());
  in_world_ = std::make_unique<InWorld>(std::move(board), index, std::move(capsules), law, links);
}

void CrtkCycle::join_bodies(std::shared_ptr<Bodies> bodies, int tool) {
  if (!arm_) throw std::invalid_argument("crtk: rigid bodies need a model of the follower");
  body_port_ = std::make_unique<BodyPort>(std::move(bodies), tool, *arm_);
}

// Shows the tool to the other cycles and to the bodies, and computes their force on it. A tool whose pose is not
// trusted is not shown: the others see it at rest where it was, and it receives no force.
void CrtkCycle::meet(bool trusted) noexcept {
  in_.tool.F_others_W = {F_pushed_W_, Vec3::Zero()};
  if (!in_world_ && !body_port_) return;
  const Pose X_WO = on_tool_.X_WO;
  on_tool_ = OnTool{};
  if (trusted && arm_ && joints_known() && std::isfinite(in_.tool.jaw)) {
    const double dt = met_at_ > 0.0 ? last_.t - met_at_ : 0.0, rate = dt > 0.0 ? 1.0 / dt : 0.0;
    if (in_world_) {
      in_world_->publish({options_.X_WL * in_.handle.X_LH.p, in_.tool.X_WT, model_base(*arm_), &*arm_, in_.tool.jaw,
                          rate, low_pass_coefficient(kTwistCutoff, dt)});
      on_tool_ = in_world_->step();
    } else {
      on_tool_.X_WO = X_WO;
    }
    if (body_port_) {
      // The engine has moved the virtual tool to the last pose handed over: against the present one it would drag.
      on_tool_.add(body_port_->step(*arm_));
      body_port_->publish(in_.tool.X_WT, in_.tool.jaw, rate, *arm_, model_base(*arm_));
    }
    met_at_ = last_.t;
  }
  in_.tool.F_others_W = in_.tool.F_others_W + on_tool_.F_T_W;
  in_.tool.K_others = on_tool_.stiffness;
  in_.tool.power_others = on_tool_.power;
}

// Computes the centres of the spheres. A sphere on a link whose pose is unknown is NaN and touches nothing.
void CrtkCycle::place_spheres(bool joints_known) noexcept {
  ToolWithSpheres& tool = in_.tool;
  const Pose X_WA = joints_known && arm_ ? model_base(*arm_) : Pose{};
  tool.p_WS[0] = tool.X_WT.p;
  std::size_t s = 0;
  for (const contact::ToolSphere& sphere : options_.contact.spheres) {
    ++s;
    if (sphere.link < 0 && sphere.link != contact::kCarried) {
      tool.place(s, sphere, tool.X_WT);
    } else if (sphere.link >= 0 && joints_known && arm_) {
      tool.place(s, sphere, X_WA * arm_->link_pose(sphere.link));
    } else {
      tool.leave_out(s);
    }
  }
}

// True if the follower is where it was sent. While it homes, or after somebody else has moved it, it is not: until it
// follows again its goal is the measured pose, so that it starts there. `settled`: the goal has rested for so long that
// no lag is left.
bool CrtkCycle::is_at_goal(bool settled) const noexcept {
  const double lag = (out_.X_BT_goal.p - X_BT_.p).norm();
  if (!settled) return lag <= options_.max_lag;
  return lag <= kHeldLag && rotation_vector(Mat3(out_.X_BT_goal.R.transpose() * X_BT_.R)).norm() <= kHeldTurn;
}

// Computes the goal of the follower, and moves a virtual follower to it. Returns bits of Status.
unsigned CrtkCycle::follow(const HapticsOutput& felt) noexcept {
  out_.X_BT_goal = options_.X_WB.inverse() * felt.mapped.X_WT_goal;
  out_.jaw = felt.mapped.jaw;
  out_.tau_gripper = in_.handle.valid ? felt.tau_gripper : 0.0;
  out_.move = options_.own_teleop && !options_.virtual_follower && felt.mapped.engaged;
  if (felt.mapped.engaged) engaged_at_ = last_.t;
  const bool at_goal = in_.homed && is_at_goal(last_.t - engaged_at_ > kSettled);
  moved_ = !felt.mapped.engaged && (moved_ || !at_goal);
  bool reached = options_.own_teleop && at_goal && !moved_;
  if (options_.virtual_follower && arm_) {
    reached = reach_.step(*arm_, out_.X_BT_goal, options_.X_WB.R, q_step_, q_follower_);
    in_.J_WT = reach_.J_WT();
    in_.tool.jaw = out_.jaw;
  }
  in_.tool.reached = reached && in_.tool.valid;
  return options_.virtual_follower && !reached ? kIkFailed : kOk;
}

// The wrench of the haptics, which limit its growth in real time. A wrench that is no longer allowed falls to zero
// linearly within `release`, or faster if the output of the haptics does.
Wrench CrtkCycle::released(const Wrench& F, bool allowed, double dt) const noexcept {
  if (allowed) return F;
  const stability::Options& caps = options_.stability;
  const double share = dt / options_.release;
  return {within(F_.f, std::min(F.f.norm(), std::max(F_.f.norm() - share * caps.force_cap, 0.0))),
          within(F_.t, std::min(F.t.norm(), std::max(F_.t.norm() - share * caps.moment_cap, 0.0)))};
}

}  // namespace palpate::loop
