#include "palpate/loop/cycle.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace palpate::loop {
namespace {

double period(double rate) {
  if (!(rate >= 50.0 && rate <= 10000.0)) {
    throw std::invalid_argument("rate = " + std::to_string(rate) +
                                " Hz: the haptic cycle runs between 50 and 10000 Hz, for example 1000");
  }
  return 1.0 / rate;
}

/// Finite, and no number whose sums or sines are not: no joint is a million radians, metres or radians a second away.
bool believable(const JointVector& x) noexcept { return (x.array().abs() < 1e6).all(); }

}  // namespace

Cycle::Cycle(const CycleOptions& options, arm::Arm leader, arm::Arm follower)
    : options_(options),
      leader_(std::move(leader)),
      follower_(std::move(follower)),
      contact_(options.method, options.contact),
      mapping_(options.mapping, options.X_WL.R, period(options.rate)),
      estimate_(options.source == force::Source::contact
                    ? nullptr
                    : std::make_unique<force::Estimate>(follower_, options.estimate)),
      stability_(options.stability, period(options.rate)),
      ledger_(options.stability.passivity.observer.delay, period(options.rate)),
      torque_(options.torque, leader_.tau_max(), period(options.rate)),
      zero_(JointVector::Zero(follower_.n())),
      q_step_(follower_.v_max() / options.rate) {
  if (!(q_step_.array() > 0.0).all()) {
    throw std::invalid_argument("the follower's velocity limits must be above zero: give them in its URDF");
  }
  for (const contact::Sphere& sphere : options.contact.spheres) {
    if (sphere.link >= static_cast<int>(follower_.link_names().size())) {
      throw std::invalid_argument("contact: a sphere sits on link " + std::to_string(sphere.link) +
                                  ", the follower has " + std::to_string(follower_.link_names().size()) + " links");
    }
  }
  out_.leader = LeaderCommand(leader_.n());
  out_.follower = {zero_, 0.0, false};
}

CycleOutput& Cycle::step(const CycleInput& in) noexcept {
  out_.tick = Tick{};
  if (!trust(in)) {
    hold_up();  // an arm has not been heard of yet: no force, no motion
    return out_;
  }
  locate();
  const mapping::Output mapped =
      mapping_.step({options_.X_WL * X_LH_, V_LH_, leader_state_.gripper, X_WT_, follower_state_.jaw,
                     in.controls.following && leader_good_ && follower_good_, in.controls.clutch, reached_});
  const bool reached = reach(mapped.X_WT_goal, mapped.jaw);
  reached_ = reached && follower_good_;
  const contact::ContactSet& contacts = contact_.step(*in.scene, p_WS_.data(), in.t);
  const force::ForceTerms force =
      force::step(contacts, mapped.V_WT, in.controls.stiffness_scale, in.controls.damping_scale);
  const Wrench wanted = mapping_.wrench_on_hand(felt(force));
  const stability::Output rendered = stabilise(wanted, mapped.engaged, force.F, contacts, in);
  const unsigned driven = torque_.step(leader_, {leader_state_, rendered.F_H_L, leader_good_}, out_.leader);
  stability_.rendered(out_.leader.F_H_L);

  out_.tick.status = rendered.status | driven | (reached ? 0u : kIkFailed) | static_cast<unsigned>(out_.tick.status);
  // While the tool holds, nothing of what the hand does moves the contact: there is nothing to be taken or withheld.
  book(rendered, mapped.engaged ? wanted : Wrench{}, contacts, force, in);
  record(mapped, contacts, force, in.controls.stiffness_scale);
  return out_;
}

// Gravity compensation alone, as soon as the leader's joints are known.
void Cycle::hold_up() noexcept {
  if (leader_known_) {
    leader_.update(leader_state_.q, leader_state_.v);
    X_LH_ = leader_.tip();
    V_LH_ = leader_.twist();
    torque_.step(leader_, {leader_state_, {}, false}, out_.leader);
    record_leader();
  }
}

// Where handle and tool are, and how fast.
void Cycle::locate() noexcept {
  leader_.update(leader_state_.q, leader_state_.v);
  follower_.update(follower_state_.q, zero_);
  X_LH_ = leader_.tip();
  V_LH_ = leader_.twist();
  if (!leader_.orients()) {  // its tip turns as it must, not as the hand wants: the tool keeps its own orientation
    X_LH_.R.setIdentity();
    V_LH_.w.setZero();
  }
  X_WT_ = options_.X_WB * follower_.tip();
  p_WS_[0] = X_WT_.p;
  std::size_t s = 0;
  for (const contact::Sphere& sphere : options_.contact.spheres) {
    const Vec3 p = sphere.centre(follower_state_.jaw);
    p_WS_[++s] = sphere.link < 0 ? X_WT_ * p : options_.X_WB * (follower_.link_pose(sphere.link) * p);
  }
}

// Keeps the last states that are finite and valid. False while an arm has not yet been heard of.
bool Cycle::trust(const CycleInput& in) noexcept {
  const LeaderState& leader = in.leader;
  const FollowerState& follower = in.follower;
  const bool leader_fits = leader.q.size() == leader_.n() && leader.v.size() == leader_.n();
  const bool follower_fits = follower.q.size() == follower_.n();
  const bool leader_finite =
      leader_fits && believable(leader.q) && believable(leader.v) && std::isfinite(leader.gripper);
  const bool follower_finite = follower_fits && believable(follower.q) && std::isfinite(follower.jaw);
  const bool leader_usable = leader.valid && leader_finite;
  const bool follower_usable = follower.valid && follower_finite;

  if (leader_usable) {
    leader_state_ = leader;
  } else {
    leader_state_.v.setZero();
  }
  if (follower_usable) {
    follower_state_ = follower;
  }
  leader_known_ |= leader_usable;
  follower_known_ |= follower_usable;
  // Any usable state will do to hold the arm up; motion and force want a fresh one. A hand, or a tool, that was out of
  // sight has moved: the map is caught anew, as after a clutch, and the follower starts from where it is.
  const bool follower_was_good = follower_good_;
  leader_good_ = leader_usable && !stability_.stale(in.t, leader.t);
  follower_good_ = follower_usable && !stability_.stale(in.t, follower.t);
  if (follower_good_ && !follower_was_good) {
    out_.follower = {follower.q, follower.jaw, true};
  }

  const Controls& c = in.controls;
  out_.tick.t = in.t;
  out_.tick.status = (leader_good_ ? 0u : kLeaderStale) | (follower_good_ ? 0u : kFollowerStale) |
                     (leader_finite && follower_finite ? 0u : kNotFinite) | (c.clutch ? kClutched : 0u) |
                     (c.following ? 0u : kNotFollowing);
  return leader_known_ && follower_known_;
}

// The follower's joints for a goal, no faster than they may turn: where the goal comes back into reach they are not
// those of where it left. The last ones when there are none.
bool Cycle::reach(const Pose& X_WT_goal, double jaw) noexcept {
  JointVector q = out_.follower.q;
  const bool reached = follower_.ik(options_.X_WB.inverse() * X_WT_goal, q).converged && q.allFinite();
  if (reached) {
    out_.follower.q += (q - out_.follower.q).cwiseMax(-q_step_).cwiseMin(q_step_).eval();
  }
  out_.follower.jaw = jaw;
  return reached;
}

// What the hand is to feel at the tool, in W: of the virtual surfaces, of the real ones, or of both.
Wrench Cycle::felt(const force::ForceTerms& force) noexcept {
  if (!estimate_) return {force.F, force.torque};
  if (!follower_good_) estimate_->reset();
  if (!estimate_->believes(follower_state_)) out_.tick.status += static_cast<double>(kNoTorques);
  const Vec3 F_T_W = follower_good_ ? Vec3(options_.X_WB.R * estimate_->step(follower_state_)) : Vec3::Zero();
  Vec3::Map(out_.tick.F_estimate_W) = F_T_W;
  if (options_.source == force::Source::estimate) return {F_T_W, Vec3::Zero()};
  return {force.F + F_T_W, force.torque};
}

// The stage `stability`, which knows the handle's motion and how stiff it is that pushes.
stability::Output Cycle::stabilise(const Wrench& wanted, bool engaged, const Vec3& F_T_W,
                                   const contact::ContactSet& contacts, const CycleInput& in) noexcept {
  stability::Input now;
  now.F_H_L = wanted;
  now.t = in.t;
  now.t_leader = leader_state_.t;
  now.t_follower = follower_state_.t;
  now.leader_valid = leader_good_;
  now.follower_valid = follower_good_;
  now.engaged = engaged;
  now.X_LH = X_LH_;
  now.V_LH = V_LH_;
  now.q = leader_state_.q;
  now.stiffness = options_.mapping.force_scale * options_.mapping.scale *
                  stability::stiffness_along(F_T_W, contacts, in.controls.stiffness_scale);
  return stability_.step(now);
}

}  // namespace palpate::loop
