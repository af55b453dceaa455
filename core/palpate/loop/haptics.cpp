#include "palpate/loop/haptics.hpp"

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

Haptics::Haptics(const HapticsOptions& options)
    : options_(options),
      mapping_(options.mapping, options.X_WL.R, period(options.rate)),
      contact_(options.method, options.contact),
      stability_(options.stability, period(options.rate)),
      ledger_(options.stability.passivity.observer.delay, period(options.rate)) {}

const HapticsOutput& Haptics::step(const HapticsInput& in) noexcept {
  const Handle& handle = in.handle;
  const Instrument& tool = in.tool;
  const bool following = in.controls.following && handle.good && tool.good;
  out_.mapped = mapping_.step({options_.X_WL * handle.X_LH, handle.V_LH, handle.gripper, tool.X_WT, tool.jaw, following,
                               in.controls.clutch, tool.reached});
  out_.contacts = &contact_.step(*in.scene, tool.p_WS.data(), in.t);
  out_.force = force::step(*out_.contacts, out_.mapped.V_WT, in.controls.stiffness_scale, in.controls.damping_scale);
  out_.wanted = mapping_.wrench_on_hand(felt(in));
  out_.rendered = stabilise(in);
  return out_;
}

void Haptics::finish(const HapticsInput& in, const Wrench& F_H_L, Tick& tick) noexcept {
  stability_.rendered(F_H_L);
  const stability::Energy energy = book(in, F_H_L);
  record(in, tick);
  record_stability(in, F_H_L, energy, tick);
}

// What the hand is to feel at the tool, in W: of the virtual surfaces, of the real ones, or of both.
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
  now.stiffness = options_.mapping.force_scale * options_.mapping.scale *
                  stability::stiffness_along(out_.force.F, *out_.contacts, in.controls.stiffness_scale);
  return stability_.step(now);
}

}  // namespace palpate::loop
