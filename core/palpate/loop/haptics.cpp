#include "palpate/loop/haptics.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "palpate/loop/soft_objects.hpp"
#include "palpate/scene/deformed_scope.hpp"
#include "palpate/types/so3.hpp"
#include "palpate/types/virtual_work.hpp"

namespace palpate::loop {
namespace {

constexpr double kRounding = 1e-6;  // [periods] smaller differences of a period are rounding errors

double period(double rate) {
  if (!(rate >= 50.0 && rate <= 10000.0)) {
    throw std::invalid_argument("rate = " + std::to_string(rate) +
                                " Hz: the haptic cycle runs between 50 and 10000 Hz, for example 1000");
  }
  return 1.0 / rate;
}

/// True if people let the hand move without the tool. All other pauses are faults.
bool asks_for_pause(const HapticsInput& in) noexcept {
  const Controls& c = in.controls;
  return c.clutch || c.camera || c.hold_all || !c.following || !c.operator_present || !c.power || !c.home ||
         !in.homed || in.execute || in.X_WT_planned != nullptr;
}

bool touches_soft_body(const ContactSet& contacts) noexcept {
  return std::any_of(contacts.contact.begin(), contacts.contact.begin() + contacts.size,
                     [](const Contact& c) { return c.stored >= 0.0; });
}

}  // namespace

Haptics::Haptics(const HapticsOptions& options)
    : options_(options),
      R_WL0_(options.X_WL.R),
      mapping_(options.mapping, options.X_WL.R, period(options.rate)),
      contact_(options.method, options.contact),
      stability_(options.stability, period(options.rate)),
      ledger_(options.stability.passivity.observer.delay, period(options.rate)),
      gripper_(options.stability.gripper_cap, period(options.rate)) {
  guidance::check(options.guidance);
}

const HapticsOutput& Haptics::step(const HapticsInput& in) noexcept {
  const Handle& handle = in.handle;
  dt_ = elapsed(in.t);
  const ToolWithSpheres& tool = in.tool;
  take_mapping(in.controls);
  const bool following = advance(in) == SessionState::following;
  out_.mapped =
      mapping_.step({options_.X_WL * handle.X_LH, handle.V_LH, handle.gripper, tool.X_WT, tool.jaw, following,
                     in.controls.clutch, tool.reached, in.t, handle.X_LH.p, at_goal_.f, out_.guided.correction,
                     in.controls.lock_rotation, in.controls.lock_translation, asks_for_pause(in), at_goal_.t});
  if (in.X_WT_planned != nullptr) out_.mapped.X_WT_goal = *in.X_WT_planned;
  contact_.jump(jump_.made(tool.X_WT));
  mark(Stage::mapping);
  guide(in);
  mark(Stage::guidance);
  out_.contacts = &contact_.step(*in.scene, tool.p_WS.data(), in.t);
  mark(Stage::contact);
  out_.force = force::step(*out_.contacts, out_.V_WT, in.controls.stiffness_scale, in.controls.damping_scale);
  tool_force_ = contact_force(in);
  at_goal_ = carried_to_goal(in, tool_force_.F_T_W) + out_.guided.on_tool.F;
  out_.tau_jaw = torque_on_jaws(tool);
  out_.commanded = mapping_.damped_wrench_on_hand({at_goal_, out_.guided.on_tool.B});
  if (in.controls.lock_rotation) out_.commanded.F.t.setZero();  // a moment that turns no tool could feed the hand
  advance_soft(*in.scene, contact_, *out_.contacts, out_.force, in.t, 1.0 / options_.rate);
  soft_ = soft_state(*in.scene);
  mark(Stage::force);
  out_.rendered = stabilise(in);
  const bool gripped = out_.mapped.engaged && handle.valid && tool.valid;
  out_.tau_gripper = gripper_.step(gripped ? mapping_.torque_on_fingers(out_.tau_jaw) : 0.0);
  mark(Stage::stability);
  return out_;
}

// Time since the last tick [s]. Rounding errors of the clock count as the nominal period.
double Haptics::elapsed(double t) noexcept {
  const double period = 1.0 / options_.rate, passed = t - t_;
  t_ = t;
  const bool nominal = !(passed > 0.0 && std::isfinite(passed)) || std::abs(passed - period) < kRounding * period;
  return nominal ? period : passed;
}

// Steps the state machine by the levels of this tick. A fault waits for a new request unless it is left by itself.
SessionState Haptics::advance(const HapticsInput& in) noexcept {
  const Controls& c = in.controls;
  const bool valid = in.handle.valid && in.tool.valid;
  const bool leaves_fault = session_.state() == SessionState::fault || session_.state() == SessionState::recover;
  if (session_.state() != SessionState::fault) recover_seen_ = c.recover_requests;
  SessionInput now;
  now.power = c.power;
  now.home = c.home;
  now.at_home = in.homed;
  now.follow = c.following && c.operator_present;
  now.aligned = mapping_.aligned(options_.X_WL * in.handle.X_LH, in.tool.X_WT) && !in.moving;
  now.execute = in.execute;
  now.moving = in.moving;
  now.clutch = c.clutch;
  now.camera = c.camera;
  now.hold = c.hold_all;
  now.fault = !valid && !(in.settling && leaves_fault);
  now.recover = c.recover_by_itself || c.recover_requests != recover_seen_;
  now.settled = valid;
  return session_.step(now);
}

// Takes the motion scale, the orientation of the leader base and requests, if they have changed.
void Haptics::take_mapping(const Controls& controls) noexcept {
  if (controls.take_back_requests != take_back_seen_) {
    take_back_seen_ = controls.take_back_requests;
    mapping_.take_back();
  }
  if (controls.scale != scale_) {
    scale_ = controls.scale;
    mapping_.rescale(scale_ > 0.0 ? scale_ : options_.mapping.scale);
  }
  if (controls.quat_WL != quat_WL_) {
    const Eigen::Vector4d& q = quat_WL_ = controls.quat_WL;
    options_.X_WL.R =
        q.isZero() ? R_WL0_ : Mat3(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix());
    mapping_.turn(options_.X_WL.R);
  }
}

// True if the hand receives forces. A constant force on a hand that does not move the tool would feed it with energy.
bool Haptics::feels(const HapticsInput& in) const noexcept {
  return out_.mapped.engaged && !in.controls.lock_translation;
}

void Haptics::finish(const HapticsInput& in, const Wrench& F, Tick& tick) noexcept {
  const Wrench F_H_L = DampedWrench{F, out_.rendered.on_hand.B}.total(in.handle.V_LH.v);
  stability_.rendered(F_H_L);
  const stability::Energy energy = book(in, F_H_L);
  record(in, tick);
  record_stability(in, F_H_L, energy, tick);
}

void Haptics::take(const guidance::ActiveFixtures& active) noexcept {
  guidance_ = active.stage.get();
  tool_frame_ = active.fixtures->tool.get();
  if (guidance_ != nullptr) guidance_->take(*active.fixtures);
}

// Lets the fixtures correct the goal and compute their wrench on the tool.
void Haptics::guide(const HapticsInput& in) noexcept {
  const scene::DeformedScope deformed(*in.scene);
  const Pose X_mapped = out_.mapped.X_WT_goal;
  out_.R_WT_mapped = X_mapped.R;
  if (guidance_ != nullptr) {
    out_.guided = guidance_->step({in.t, out_.mapped, in.tool, tool_force_, in.handle, in.controls.guidance});
  } else {
    out_.guided.X_WT_goal = out_.mapped.X_WT_goal;
    out_.guided.J_goal.setIdentity();
    if (tool_frame_ != nullptr) tool_frame_->set({in.tool.X_WT, out_.mapped.V_WT});
  }
  // A planned goal is free as it is: a fixture that would correct it stops the motion instead (Cycle::guard).
  if (in.X_WT_planned == nullptr) {
    out_.mapped.X_WT_goal = out_.guided.X_WT_goal;
  } else {
    out_.guided.J_goal.setIdentity();
  }
  jump_.see(X_mapped, out_.mapped.X_WT_goal, out_.guided.J_goal);
  out_.V_WT = carried(out_.guided.J_goal, out_.mapped.V_WT);
  if (in.J_WT != nullptr) out_.V_WT = carried(*in.J_WT, out_.V_WT);
  mapping_.set_commanded_goal(out_.mapped.X_WT_goal);
}

// Torque of the contacts about the hinges of the jaws, by the principle of virtual work.
double Haptics::torque_on_jaws(const ToolWithSpheres& tool) const noexcept {
  double sum = 0.0;
  if (options_.source == force::Source::estimate) return sum;
  for (int i = 0; i < out_.contacts->size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto s = static_cast<std::size_t>(out_.contacts->contact[k].sphere);
    sum += tool.jaw_motion_W[s].dot(out_.force.F_contact[k].f);
  }
  return sum;
}

// The contact force that the hand is to feel, in W: of the virtual surfaces, of the real ones, or of both.
ToolForce Haptics::contact_force(const HapticsInput& in) const noexcept {
  const Vec3& F_estimate_W = in.tool.F_estimate_W;
  switch (options_.source) {
    case force::Source::estimate:
      return {{F_estimate_W, Vec3::Zero()}};
    case force::Source::both:
      return {{out_.force.F + F_estimate_W, out_.force.torque}};
    default:
      return {Wrench{out_.force.F, out_.force.torque} + in.tool.F_others_W,
              stability::stiffness_along(out_.force.F, *out_.contacts, in.controls.stiffness_scale) + in.tool.K_others};
  }
}

// The wrench at the mapped goal that does the same work as F_T_W on the tool, in W: the transposes of the maps of the
// follower's reach and of the hard fixtures' correction (NOTATION.md, "Virtual work").
Wrench Haptics::carried_to_goal(const HapticsInput& in, const Wrench& F_T_W) const noexcept {
  return carried_back(out_.guided.J_goal, in.J_WT != nullptr ? carried_back(*in.J_WT, F_T_W) : F_T_W);
}

// Energy that the springs behind the wrench on the hand store now, at the hand's port [J]; infinity for a soft body,
// another instrument and a measured contact, whose stored energy is not known. of_fixtures: that of the fixtures [J].
double Haptics::spring_energy(const HapticsInput& in, double of_fixtures) const noexcept {
  const bool others = in.tool.F_others_W.f != Vec3::Zero() || in.tool.F_others_W.t != Vec3::Zero();
  if (options_.source != force::Source::contact || others || touches_soft_body(*out_.contacts)) {
    return std::numeric_limits<double>::infinity();
  }
  return mapping_.energy_ratio() *
         (stability::spring_energy(*out_.contacts, in.controls.stiffness_scale) + of_fixtures);
}

// Where the tool does not reach its goal (the follower's lag or limits), the hand has also worked against the present
// wrench along the distance between both: at most this energy, at the hand's port [J].
double Haptics::energy_of_lag(const HapticsInput& in) const noexcept {
  const Wrench& F = tool_force_.F_T_W;
  const Pose& goal = out_.mapped.X_WT_goal;
  const double away = (goal.p - in.tool.X_WT.p).norm();
  const double turned = rotation_vector(goal.R * in.tool.X_WT.R.transpose()).norm();
  return mapping_.energy_ratio() * (F.f.norm() * away + F.t.norm() * turned);
}

// Power that the motion of the touched surfaces and of other instruments does on the tool [W].
double Haptics::power_of_motion(const HapticsInput& in) const noexcept {
  if (options_.source != force::Source::contact) return 0.0;
  double power = in.tool.power_others;
  for (int i = 0; i < out_.contacts->size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Contact& c = out_.contacts->contact[k];
    if (c.stored < 0.0) power += out_.force.F_contact[k].f.dot(c.v_surface);  // a soft body moves with the tool
  }
  return power;
}

stability::Output Haptics::stabilise(const HapticsInput& in) noexcept {
  const Vec3 F_T_W = carried_to_goal(in, {out_.force.F, out_.force.torque}).f + out_.guided.on_tool.F.f;
  const double K = stability::stiffness_along(F_T_W, *out_.contacts, in.controls.stiffness_scale) +
                   (guidance_ != nullptr ? guidance_->stiffness_along(F_T_W) : 0.0) + in.tool.K_others;
  const guidance::FixtureEnergy& energy = out_.guided.energy;
  return stability_.step({out_.commanded, in.t, in.handle, in.tool, feels(in), mapping_.stiffness_on_hand(K),
                          mapping_.energy_ratio() * energy.credit, dt_, mapping_.energy_ratio() * power_of_motion(in),
                          spring_energy(in, energy.potential) + energy_of_lag(in), spring_energy(in, energy.present)});
}

}  // namespace palpate::loop
