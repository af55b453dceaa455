// The record of the haptics: energies by their source, and the signals of a tick.
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "palpate/loop/haptics.hpp"
#include "palpate/loop/record.hpp"

namespace palpate::loop {
namespace {

const Contact* strongest(const ContactSet& contacts) noexcept {
  const auto first = contacts.contact.begin();
  const auto deepest =
      std::max_element(first, first + contacts.size, [](const auto& a, const auto& b) { return a.depth < b.depth; });
  return contacts.size > 0 ? &*deepest : nullptr;
}

Wrench finite(const Wrench& F) noexcept { return F.f.allFinite() && F.t.allFinite() ? F : Wrench{}; }

}  // namespace

void record(const Handle& handle, Tick& tick) noexcept {
  tick.gripper = handle.gripper;
  copy(handle.X_LH.p, tick.p_LH);
  copy(handle.X_LH.R, tick.quat_LH);
  copy(handle.V_LH.v, tick.v_LH);
}

// Splits the wrench on the hand into its parts and books the energy of each. While the mapping is released, the hand
// does not move the tool, so no wrench is wanted.
stability::Energy Haptics::book(const HapticsInput& in, const Wrench& F_H_L) noexcept {
  const ContactSet& contacts = *out_.contacts;
  const stability::Output& rendered = out_.rendered;
  const Vec3& v_LH = in.handle.V_LH.v;
  const Wrench commanded = feels(in) ? out_.commanded.total(v_LH) : Wrench{};
  const bool law = options_.source != force::Source::estimate;  // the force law contributes to the wrench on the hand
  const bool engaged = commanded.f != Vec3::Zero() || commanded.t != Vec3::Zero();
  stability::PortForces forces;
  forces.F_H_L = F_H_L;
  forces.F_cut = rendered.F_cut + (rendered.F_H_L - F_H_L);
  forces.F_passivity = rendered.F_passivity;
  forces.F_low_pass = rendered.F_low_pass;
  forces.F_coupling = rendered.F_coupling;
  if (law)
    forces.F_damping =
        finite(mapping_.wrench_on_hand(carried_to_goal(in, {out_.force.F_damping, out_.force.t_damping})));
  Wrench rest = finite(commanded);
  for (int i = 0; law && engaged && i < contacts.size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int object = contacts.contact[k].object;
    if (object >= kGuidanceSource) continue;
    Wrench& source = forces.F_source[static_cast<std::size_t>(object)];
    const Wrench F_contact = finite(mapping_.wrench_on_hand(carried_to_goal(in, out_.force.F_contact[k])));
    source = source + F_contact;
    rest = rest - F_contact;
  }
  if (feels(in)) {
    const Wrench F_guidance = finite(mapping_.damped_wrench_on_hand(out_.guided.on_tool).total(v_LH));
    forces.F_source[kGuidanceSource] = F_guidance;
    rest = rest - F_guidance;
  }
  forces.F_source.back() = rest;
  // Energy of the contact springs, converted to the hand's port.
  const double per_hand = law ? mapping_.energy_ratio() : 0.0;
  const double spring =
      per_hand * (stability::spring_energy(contacts, in.controls.stiffness_scale) + soft_.potential + soft_.kinetic);
  return ledger_.step(in.handle.X_LH, forces, spring, mapping_.energy_ratio() * mapping_.released(), dt_);
}

void Haptics::record(const HapticsInput& in, Tick& tick) const noexcept {
  loop::record(in.handle, tick);
  const Pose& X_WT = in.tool.X_WT;
  tick.session_state = static_cast<double>(session_.state());
  tick.jaw = in.tool.jaw;
  tick.jaw_goal = out_.mapped.jaw;
  tick.tau_jaw = out_.tau_jaw;
  tick.tau_gripper = out_.tau_gripper;
  copy(out_.mapped.X_WT_goal.p, tick.p_WT_goal);
  copy(mapping_.shift(), tick.p_shift_W);
  copy(X_WT.p, tick.p_WT);
  copy(X_WT.R, tick.quat_WT);
  copy(X_WT.p, tick.p_WP);
  if (const Contact* c = strongest(*out_.contacts)) {
    copy(c->p_proxy, tick.p_WP);
    copy(c->normal, tick.normal);
    copy(c->delta_x, tick.delta_x);
    tick.depth = c->depth;
  }
  tick.contacts = out_.contacts->size;
  record_touches(in.controls.stiffness_scale, tick);
  copy(out_.force.F, tick.F_T_W);
  copy(out_.force.torque, tick.t_T_W);
  copy(out_.force.F_spring, tick.F_spring_W);
  copy(out_.force.F_damping, tick.F_damping_W);
  copy(in.tool.F_estimate_W, tick.F_estimate_W);
  record_guidance(tick);
}

void Haptics::record_guidance(Tick& tick) const noexcept {
  const guidance::Output& guided = out_.guided;
  copy(guided.on_tool.F.f, tick.F_guidance_W);
  copy(guided.on_tool.F.t, tick.t_guidance_W);
  copy(out_.R_WT_mapped, tick.quat_WT_asked);
  copy(guided.correction, tick.p_correction_W);
  tick.guidance_fixture = guided.strongest;
  tick.guidance_gap = guided.gap;
  tick.status |= guided.status;
}

// Records each contact, the strongest first.
void Haptics::record_touches(double stiffness_scale, Tick& tick) const noexcept {
  const ContactSet& contacts = *out_.contacts;
  std::array<std::pair<double, int>, kMaxContacts> order;
  for (int i = 0; i < contacts.size; ++i) {
    const Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    order[static_cast<std::size_t>(i)] = {-stiffness_scale * c.normal.dot(c.material.K.cwiseProduct(c.delta_x)), i};
  }
  std::sort(order.begin(), order.begin() + contacts.size);
  for (int k = 0; k < std::min(contacts.size, kTouches); ++k) {
    const auto& [minus_force, i] = order[static_cast<std::size_t>(k)];
    const Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    tick.touch_sphere[k] = c.sphere;
    tick.touch_object[k] = c.object;
    tick.touch_force[k] = -minus_force;
    Vec3::Map(tick.p_WC + 3 * static_cast<std::ptrdiff_t>(k)) = c.p_C;
  }
}

// Records who withholds how much of the force that is asked of the hand: the losses of magnitude along the chain, which
// add up to the difference between the asked and the rendered force. A loss is negative where an element holds a force
// that is no longer asked for.
void Haptics::record_withheld(const HapticsInput& in, const Wrench& F_H_L, Tick& tick) const noexcept {
  const stability::Output& rendered = out_.rendered;
  const Vec3& v_LH = in.handle.V_LH.v;
  const double asked = finite(out_.commanded.total(v_LH)).f.norm(), felt = F_H_L.f.norm();
  tick.F_asked[0] = asked;
  tick.F_asked[1] = finite(mapping_.wrench_on_hand(tool_force_.F_T_W)).f.norm();
  tick.F_asked[2] = finite(mapping_.damped_wrench_on_hand(out_.guided.on_tool).total(v_LH)).f.norm();
  if (!feels(in) || !in.handle.valid || !in.tool.valid) {
    tick.F_withheld[kWithholders - 1] = asked - felt;
    return;
  }
  const Vec3 after_low_pass = rendered.F_capped.f + rendered.F_cut.f;
  const double after_coupling = (after_low_pass + rendered.F_low_pass.f).norm(), smooth = after_low_pass.norm();
  const double capped = std::min(smooth, options_.stability.force_cap), left = rendered.F_H_L.f.norm();
  // The limiter continues from the rendered force. While the passivity controller reduces that, it causes both losses.
  const double limited = (rendered.status & kPassivity) != 0 ? capped : rendered.F_capped.f.norm();
  const std::array<double, kWithholders> parts = {asked - after_coupling,
                                                  after_coupling - smooth,
                                                  limited - left,
                                                  smooth - capped,
                                                  capped - limited,
                                                  left - felt,
                                                  0.0};
  std::copy(parts.begin(), parts.end(), tick.F_withheld);
}

void Haptics::record_stability(const HapticsInput& in, const Wrench& F_H_L, const stability::Energy& energy,
                               Tick& tick) const noexcept {
  record_withheld(in, F_H_L, tick);
  copy(F_H_L.f, tick.F_H_L);
  copy(F_H_L.t, tick.t_H_L);
  copy(in.handle.X_LH.R.transpose() * F_H_L.f, tick.F_H_H);
  tick.energy_port = energy.port;
  tick.energy_spring = energy.spring;
  tick.energy_damping = energy.damping;
  tick.energy_mapping = energy.mapping;
  tick.energy_cut = energy.cut;
  tick.energy_passivity = energy.passivity;
  tick.energy_low_pass = energy.low_pass;
  tick.energy_coupling = energy.coupling;
  std::copy(energy.source.begin(), energy.source.end(), tick.energy_source);
  tick.tissue_potential = soft_.potential;
  tick.tissue_kinetic = soft_.kinetic;
  tick.tissue_status = (soft_.hurried ? 1.0 : 0.0) + (soft_.frozen ? 2.0 : 0.0) + (soft_.late ? 4.0 : 0.0);
  if (soft_.frozen) tick.status |= kSoftFrozen;
  if (soft_.late) tick.status |= kSoftLate;
  if (stability_.passivity().in_deficit()) tick.status |= kDeficit;
  tick.energy_stored = stability_.passivity().stored();
  tick.energy_lent = stability_.passivity().credited();
  tick.energy_reserved = stability_.passivity().reserved();
  const stability::Lag& lag = out_.rendered.lag;
  Eigen::Vector4d::Map(tick.lag_ms) << 1e3 * lag.coupling, 1e3 * lag.low_pass, 1e3 * lag.passivity, 1e3 * lag.caps;
}

}  // namespace palpate::loop
