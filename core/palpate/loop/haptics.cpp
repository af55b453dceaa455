#include "palpate/loop/haptics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate::loop {
namespace {

double period(double rate) {
  if (!(rate >= 50.0 && rate <= 10000.0)) {
    throw std::invalid_argument("rate = " + std::to_string(rate) +
                                " Hz: the haptic cycle runs between 50 and 10000 Hz, for example 1000");
  }
  return 1.0 / rate;
}

}  // namespace

void check(const Controls& controls) {
  if (!(controls.guidance >= 0.0 && controls.guidance <= 1.0)) {
    throw std::invalid_argument("controls: guidance = " + std::to_string(controls.guidance) + " must lie in 0..1");
  }
  if (!(controls.stiffness_scale >= 0.0 && std::isfinite(controls.stiffness_scale)) ||
      !(controls.damping_scale >= 0.0 && std::isfinite(controls.damping_scale)) ||
      !controls.p_hand_offset_W.allFinite()) {
    throw std::invalid_argument(
        "controls: stiffness_scale and damping_scale must be 0 or more, p_hand_offset_W finite");
  }
}

Haptics::Haptics(const HapticsOptions& options)
    : options_(options),
      mapping_(options.mapping, options.X_WL.R, period(options.rate)),
      guidance_(options.guidance, period(options.rate)),
      contact_(options.method, options.contact),
      stability_(options.stability, period(options.rate)),
      ledger_(options.stability.passivity.observer.delay, period(options.rate)) {}

const HapticsOutput& Haptics::step(const HapticsInput& in) noexcept {
  const Handle& handle = in.handle;
  const Instrument& tool = in.tool;
  const bool following = in.controls.following && handle.good && tool.good;
  out_.mapped = mapping_.step({options_.X_WL * handle.X_LH, handle.V_LH, handle.gripper, tool.X_WT, tool.jaw, following,
                               in.controls.clutch, tool.reached});
  guide(in);
  out_.contacts = &contact_.step(*in.scene, tool.p_WS.data(), in.t);
  out_.force = force::step(*out_.contacts, out_.mapped.V_WT, in.controls.stiffness_scale, in.controls.damping_scale);
  felt_ = felt(in);
  stiffness_ = options_.source == force::Source::contact
                   ? stability::stiffness_along(out_.force.F, *out_.contacts, in.controls.stiffness_scale)
                   : 0.0;
  out_.F_B_L = {-out_.B_H_L * in.handle.V_LH.v, Vec3::Zero()};
  out_.wanted = mapping_.wrench_on_hand(felt_ + out_.guided.F_T_W) + out_.F_B_L;
  out_.rendered = stabilise(in);
  share_out(in.handle);
  return out_;
}

// Caps and passivity leave a share of the force: so much of the damping, too, is the master's to render.
void Haptics::share_out(const Handle& handle) noexcept {
  const Vec3 &wanted = out_.wanted.f, &rendered = out_.rendered.F_H_L.f;
  const double size = wanted.squaredNorm();
  const double share = size > 0.0 ? std::clamp(rendered.dot(wanted) / size, 0.0, 1.0) : 1.0;
  out_.B_H_L *= std::isfinite(share) ? share : 0.0;
  F_B_L_ = {-out_.B_H_L * handle.V_LH.v, Vec3::Zero()};
  out_.beside = out_.rendered.F_H_L - F_B_L_;
}

void Haptics::finish(const HapticsInput& in, const Wrench& beside, Tick& tick) noexcept {
  const Wrench F_H_L = beside + F_B_L_;
  stability_.rendered(F_H_L);
  const stability::Energy energy = book(in, F_H_L);
  record(in, tick);
  record_stability(in, F_H_L, energy, tick);
}

// What the fixtures make of the goal, and what the hand feels of them.
void Haptics::guide(const HapticsInput& in) noexcept {
  guidance::Input now;
  now.t = in.t;
  now.X_WT_goal = out_.mapped.X_WT_goal;
  now.V_WT = out_.mapped.V_WT;
  now.X_WT = in.tool.X_WT;
  now.engaged = out_.mapped.engaged;
  now.F_T_W = felt_.f;
  now.stiffness = stiffness_;
  now.F_hand = in.handle.F_hand;
  now.pedal = in.controls.guidance;
  now.takes_damping = in.handle.takes_damping;
  now.joints = in.tool.joints;
  out_.R_WT_asked = now.X_WT_goal.R;
  out_.guided = guidance_.step(now);
  out_.mapped.X_WT_goal = out_.guided.X_WT_goal;
  mapping_.given(out_.guided.X_WT_goal);
  const Mat3& R_WL = options_.X_WL.R;
  out_.B_H_L = mapping_.options().force_scale * mapping_.options().scale * (R_WL.transpose() * out_.guided.B_W * R_WL);
}

// What the hand is to feel of it at the tool, in W: of the virtual surfaces, of the real ones, or of both.
Wrench Haptics::felt(const HapticsInput& in) const noexcept {
  const Vec3& F_estimate_W = in.tool.F_estimate_W;
  switch (options_.source) {
    case force::Source::estimate:
      return {F_estimate_W, Vec3::Zero()};
    case force::Source::both:
      return {out_.force.F + F_estimate_W, out_.force.torque};
    default:
      return {out_.force.F, out_.force.torque};
  }
}

// The stage `stability`, which knows the handle's motion and how stiff it is that pushes.
stability::Output Haptics::stabilise(const HapticsInput& in) noexcept {
  stability::Input now;
  now.F_H_L = out_.wanted;
  now.t = in.t;
  now.t_leader = in.handle.t;
  now.t_follower = in.tool.t;
  now.leader_valid = in.handle.good;
  now.follower_valid = in.tool.good;
  now.engaged = out_.mapped.engaged;
  now.X_LH = in.handle.X_LH;
  now.V_LH = in.handle.V_LH;
  now.q = in.handle.q;
  const Vec3 F_T_W = out_.force.F + out_.guided.F_T_W.f;
  now.stiffness = mapping_.options().force_scale * mapping_.options().scale *
                  (stability::stiffness_along(F_T_W, *out_.contacts, in.controls.stiffness_scale) +
                   guidance_.stiffness_along(F_T_W));
  now.lent = mapping_.options().force_scale / mapping_.options().scale * out_.guided.lent;
  return stability_.step(now);
}

}  // namespace palpate::loop
