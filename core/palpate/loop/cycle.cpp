#include "palpate/loop/cycle.hpp"

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "palpate/loop/record.hpp"

namespace palpate::loop {
namespace {

/// True if all values are below a million [rad, m, rad/s], so that sums and sines of them are finite; false for NaN.
bool believable(const JointVector& x) noexcept { return (x.array().abs() < 1e6).all(); }

constexpr double kCorrection = 1e-5;  // [m] correction by hard fixtures above which a planned motion stops

}  // namespace

Cycle::Cycle(const CycleOptions& options, arm::Arm leader, arm::Arm follower)
    : options_(options),
      leader_(std::move(leader)),
      follower_(std::move(follower)),
      haptics_(options),
      estimate_(options.source == force::Source::contact
                    ? nullptr
                    : std::make_unique<force::Estimate>(follower_, options.estimate)),
      torque_(options.torque, leader_.tau_max(), 1.0 / options.rate),
      execution_(1.0 / options.rate),
      zero_(JointVector::Zero(follower_.n())),
      q_step_(follower_.v_max() / options.rate) {
  if (!(q_step_.array() > 0.0).all()) {
    throw std::invalid_argument("the follower's velocity limits must be above zero: give them in its URDF");
  }
  for (const contact::ToolSphere& sphere : options.contact.spheres) {
    if (sphere.link >= static_cast<int>(follower_.link_names().size())) {
      throw std::invalid_argument("contact: a sphere sits on link " + std::to_string(sphere.link) +
                                  ", the follower has " + std::to_string(follower_.link_names().size()) + " links");
    }
  }
  joints_ = {Jacobian::Zero(6, follower_.n()), zero_, follower_.q_min(), follower_.q_max(), q_step_};
  in_.tool.joints = &joints_;
  out_.leader = LeaderCommand(leader_.n());
  out_.follower = {zero_, 0.0, false};
}

CycleOutput& Cycle::step(const CycleInput& in) noexcept {
  if (clock_ != nullptr) clock_->start();
  out_.tick = Tick{};
  if (!accept_states(in)) {
    compensate_gravity();  // an arm has not yet reported a state: no force, no motion
    return out_;
  }
  in_.t = in.t;
  in_.controls = in.controls;
  in_.scene = in.scene;
  in_.tool.F_others_W = in.F_others_W;
  in_.tool.K_others = in.K_others;
  in_.tool.power_others = in.power_others;
  X_WO_ = in.X_WO;
  in_.J_WT = reach_.J_WT();
  locate();
  const unsigned estimated = estimate();
  const bool planned = execute(in);
  mark(Stage::kinematics);
  const HapticsOutput& felt = haptics_.step(in_);
  const Pose X_BT_goal = options_.X_WB.inverse() * felt.mapped.X_WT_goal;
  if (planned) reach_.reset();
  const bool reached = planned || reach_.step(follower_, X_BT_goal, options_.X_WB.R, q_step_, out_.follower.q);
  if (planned) guard(felt, in.order.guard);
  out_.follower.jaw = felt.mapped.jaw;
  in_.tool.reached = reached && in_.tool.valid;
  mark(Stage::kinematics);
  const unsigned driven = torque_.step(leader_, {leader_state_, felt.rendered.on_hand, in_.handle.valid}, out_.leader);
  mark(Stage::torque);
  haptics_.finish(in_, out_.leader.F_H_L, out_.tick);

  out_.tick.status |= felt.rendered.status | driven | estimated | (reached ? 0u : kIkFailed);
  record_leader();
  record_follower();
  mark(Stage::record);
  if (clock_ != nullptr) clock_->finish();
  return out_;
}

// Commands gravity compensation alone, once the leader's joints are known.
void Cycle::compensate_gravity() noexcept {
  if (leader_known_) {
    leader_.dynamics(leader_state_.q, leader_state_.v);
    in_.handle.X_LH = leader_.tip();
    in_.handle.V_LH = leader_.twist();
    in_.handle.gripper = leader_state_.gripper;
    torque_.step(leader_, {leader_state_, {}, false}, out_.leader);
    record(in_.handle, out_.tick);
    record_leader();
  }
}

// Moves the goal of the follower's joints along the planned motion; returns false if the hand determines the goal.
bool Cycle::execute(const CycleInput& in) noexcept {
  in_.X_WT_planned = nullptr;
  if (in.motion == nullptr) return false;
  const Controls& c = in.controls;
  const bool allowed = c.operator_present && !c.clutch && !c.camera;  // a pedal ends the motion
  const bool executing = allowed && haptics_.state() == SessionState::executing;
  const bool planned = execution_.step(*in.motion, in.order, executing, out_.follower.q);
  in_.execute = execution_.wanted();
  in_.moving = execution_.moves();
  if (!planned) return false;
  follower_.update(out_.follower.q, zero_);
  X_WT_planned_ = options_.X_WB * follower_.tip();
  in_.X_WT_planned = &X_WT_planned_;
  return true;
}

// Stops a planned motion that meets a contact or a hard fixture: along its path there should be neither.
void Cycle::guard(const HapticsOutput& felt, double most) noexcept {
  if (!(haptics_.tool_force().f.norm() <= most)) execution_.stop(ExecutionPhase::touched);
  if (felt.guided.correction.norm() > kCorrection) execution_.stop(ExecutionPhase::corrected);
}

// Computes poses and velocities of handle and tool from the joints.
void Cycle::locate() noexcept {
  leader_.dynamics(leader_state_.q, leader_state_.v);
  follower_.update(follower_state_.q, zero_);
  Handle& handle = in_.handle;
  handle.t = leader_state_.t;
  handle.X_LH = leader_.tip();
  handle.V_LH = leader_.twist();
  handle.gripper = leader_state_.gripper;
  handle.q = leader_state_.q;
  handle.renders_damping = torque_.renders_damping(leader_state_);
  handle.F_hand = leader_state_.has_load_cell ? leader_state_.F_cell_L.norm() : -1.0;
  if (!leader_.orients()) {  // the hand cannot orient this leader's tip: the tool keeps its orientation
    handle.X_LH.R.setIdentity();
    handle.V_LH.w.setZero();
  }
  in_.tool.t = follower_state_.t;
  in_.tool.X_WT = options_.X_WB * follower_.tip();
  in_.tool.jaw = follower_state_.jaw;
  joints_.q = follower_state_.q;
  joints_.J_WT.topRows<3>() = options_.X_WB.R * follower_.jacobian().topRows<3>();
  joints_.J_WT.bottomRows<3>() = options_.X_WB.R * follower_.jacobian().bottomRows<3>();
  place_spheres();
}

void Cycle::place_spheres() noexcept {
  ToolWithSpheres& tool = in_.tool;
  tool.p_WS[0] = tool.X_WT.p;
  std::size_t s = 0;
  for (const contact::ToolSphere& sphere : options_.contact.spheres) {
    ++s;
    if (sphere.link != contact::kCarried) {
      tool.place(s, sphere, sphere.link < 0 ? tool.X_WT : options_.X_WB * follower_.link_pose(sphere.link));
    } else if (X_WO_ != nullptr) {
      tool.place(s, sphere, *X_WO_);
    } else {
      tool.leave_out(s);
    }
  }
}

// True if the leader's state has one finite number per joint.
bool Cycle::is_finite(const LeaderState& leader) const noexcept {
  return leader.q.size() == leader_.n() && leader.v.size() == leader_.n() && believable(leader.q) &&
         believable(leader.v) && std::isfinite(leader.gripper);
}

// True if the follower's state has one finite number per joint.
bool Cycle::is_finite(const FollowerState& follower) const noexcept {
  return follower.q.size() == follower_.n() && believable(follower.q) && std::isfinite(follower.jaw);
}

// Keeps the last states that are finite and valid. Returns false while an arm has not yet reported one.
bool Cycle::accept_states(const CycleInput& in) noexcept {
  const bool finite = is_finite(in.leader) && is_finite(in.follower);
  const bool leader_usable = in.leader.valid && is_finite(in.leader);
  const bool follower_usable = in.follower.valid && is_finite(in.follower);
  if (leader_usable) {
    leader_state_ = in.leader;
  } else {
    leader_state_.v.setZero();
  }
  if (follower_usable) follower_state_ = in.follower;
  leader_known_ |= leader_usable;
  follower_known_ |= follower_usable;
  // Gravity compensation works with any usable state; motion and force need a fresh one. A hand or tool may have moved
  // while it was not observed, so the map is anchored anew, as after a clutch, and the follower starts at its position.
  const bool follower_was_valid = in_.tool.valid;
  in_.handle.valid = leader_usable && !haptics_.stale(in.t, in.leader.t);
  in_.tool.valid = follower_usable && !haptics_.stale(in.t, in.follower.t);
  if (in_.tool.valid && !follower_was_valid) out_.follower = {in.follower.q, in.follower.jaw, true};
  out_.tick.t = in.t;
  out_.tick.status = input_status(in.controls, finite);
  return leader_known_ && follower_known_;
}

// Status bits of the inputs of this tick: stale or not finite states, and the pedals.
unsigned Cycle::input_status(const Controls& controls, bool finite) const noexcept {
  return (in_.handle.valid ? 0u : kLeaderStale) | (in_.tool.valid ? 0u : kFollowerStale) | (finite ? 0u : kNotFinite) |
         (controls.clutch ? kClutched : 0u) | (controls.following ? 0u : kNotFollowing);
}

// Estimates the contact force on the tool from the torques of the follower's drives. Returns bits of Status.
unsigned Cycle::estimate() noexcept {
  if (!estimate_) return kOk;
  if (!in_.tool.valid) estimate_->reset();
  const unsigned status = estimate_->is_plausible(follower_state_) ? kOk : kNoTorques;
  in_.tool.F_estimate_W.setZero();
  if (in_.tool.valid) in_.tool.F_estimate_W = options_.X_WB.R * estimate_->step(follower_state_);
  return status;
}

void Cycle::record_leader() noexcept {
  Tick& tick = out_.tick;
  const LeaderCommand& command = out_.leader;
  copy(leader_state_.q, tick.q);
  copy(leader_state_.v, tick.v);
  copy(command.support_torque() + command.response_torque(), tick.tau);
  copy(command.tau_force, tick.tau_force);
  copy(command.tau_gravity, tick.tau_gravity);
  copy(command.tau_platform, tick.tau_platform);
  copy(command.tau_friction, tick.tau_friction);
  copy(command.tau_limits, tick.tau_limits);
  copy(command.F_law_L.f, tick.F_law_L);
  tick.F_neglected = command.F_neglected;
}

void Cycle::record_follower() noexcept {
  copy(follower_state_.q, out_.tick.q_follower);
  copy(follower_state_.tau, out_.tick.tau_follower);
  copy(out_.follower.q, out_.tick.q_follower_goal);
  out_.tick.execution = static_cast<double>(execution_.phase());
  out_.tick.execution_motion = static_cast<double>(execution_.motion());
  out_.tick.execution_t = execution_.time();
}

}  // namespace palpate::loop
