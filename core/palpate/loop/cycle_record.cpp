// What a cycle writes down: energies by their source, and every signal of the tick.
#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "palpate/loop/cycle.hpp"

namespace palpate::loop {
namespace {

template <std::size_t n>
void copy(const JointVector& from, double (&to)[n]) noexcept {
  std::fill_n(to, n, 0.0);
  std::copy_n(from.data(), std::min<std::size_t>(n, static_cast<std::size_t>(from.size())), to);
}

void copy(const Vec3& from, double (&to)[3]) noexcept { std::copy_n(from.data(), 3, to); }

void copy(const Mat3& R, double (&to)[4]) noexcept {
  const Eigen::Quaterniond q(R);
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  to[0] = sign * q.w(), to[1] = sign * q.x(), to[2] = sign * q.y(), to[3] = sign * q.z();
}

const contact::Contact* strongest(const contact::ContactSet& contacts) noexcept {
  const auto first = contacts.contact.begin();
  const auto deepest =
      std::max_element(first, first + contacts.size, [](const auto& a, const auto& b) { return a.depth < b.depth; });
  return contacts.size > 0 ? &*deepest : nullptr;
}

Wrench finite(const Wrench& F) noexcept { return F.f.allFinite() && F.t.allFinite() ? F : Wrench{}; }

}  // namespace

// Wrenches on the hand and the energy they move. wanted: before the stage `stability`; none while the tool holds, when
// nothing of what the hand does moves the contact.
void Cycle::book(const stability::Output& rendered, const Wrench& wanted, const contact::ContactSet& contacts,
                 const force::ForceTerms& force, const CycleInput& in) noexcept {
  const bool law = options_.source != force::Source::estimate;  // is it part of what the hand is given?
  const bool engaged = wanted.f != Vec3::Zero() || wanted.t != Vec3::Zero();
  stability::PortForces forces;
  forces.F_H_L = out_.leader.F_H_L;
  forces.F_cut = rendered.F_capped - out_.leader.F_H_L;
  forces.F_passivity = rendered.F_passivity;
  forces.F_low_pass = rendered.F_low_pass;
  forces.F_coupling = rendered.F_coupling;
  if (law) forces.F_damping = finite(mapping_.wrench_on_hand({force.F_damping, force.t_damping}));
  Wrench rest = finite(wanted);
  for (int i = 0; law && engaged && i < contacts.size; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int object = contacts.contact[k].object;
    if (object >= kSources - 1) continue;
    Wrench& source = forces.F_source[static_cast<std::size_t>(object)];
    const Wrench F_H_L = finite(mapping_.wrench_on_hand(force.of_contact[k]));
    source = source + F_H_L;
    rest = rest - F_H_L;
  }
  forces.F_source.back() = rest;
  // A spring of the tool's side, seen from the hand, which moves 1/scale as far.
  const double per_hand = law ? options_.mapping.force_scale / options_.mapping.scale : 0.0;
  const double spring = per_hand * stability::spring_energy(contacts, in.controls.stiffness_scale);
  record_stability(rendered, ledger_.step(X_LH_, forces, spring));
}

void Cycle::record_stability(const stability::Output& rendered, const stability::Energy& energy) noexcept {
  const Wrench& F_H_L = out_.leader.F_H_L;
  Tick& tick = out_.tick;
  copy(F_H_L.f, tick.F_H_L);
  copy(F_H_L.t, tick.t_H_L);
  copy(X_LH_.R.transpose() * F_H_L.f, tick.F_H_H);
  tick.energy_port = energy.port;
  tick.energy_spring = energy.spring;
  tick.energy_damping = energy.damping;
  tick.energy_cut = energy.cut;
  tick.energy_passivity = energy.passivity;
  tick.energy_low_pass = energy.low_pass;
  tick.energy_coupling = energy.coupling;
  std::copy(energy.source.begin(), energy.source.end(), tick.energy_source);
  tick.energy_stored = stability_.passivity().stored();
  tick.energy_reserved = stability_.passivity().reserved();
  const stability::Lag& lag = rendered.lag;
  Eigen::Vector4d::Map(tick.lag_ms) << 1e3 * lag.coupling, 1e3 * lag.low_pass, 1e3 * lag.passivity, 1e3 * lag.caps;
}

void Cycle::record(const mapping::Output& mapped, const contact::ContactSet& contacts, const force::ForceTerms& force,
                   double stiffness_scale) noexcept {
  Tick& tick = out_.tick;
  record_leader();
  copy(follower_state_.q, tick.q_follower);
  copy(follower_state_.tau, tick.tau_follower);
  tick.jaw = follower_state_.jaw;
  copy(mapped.X_WT_goal.p, tick.p_WT_goal);
  copy(X_WT_.p, tick.p_WT);
  copy(X_WT_.R, tick.quat_WT);
  copy(X_WT_.p, tick.p_WP);
  if (const contact::Contact* c = strongest(contacts)) {
    copy(c->p_proxy, tick.p_WP);
    copy(c->normal, tick.normal);
    copy(c->delta_x, tick.delta_x);
    tick.depth = c->depth;
  }
  tick.contacts = contacts.size;
  record_touches(contacts, stiffness_scale);
  copy(force.F, tick.F_T_W);
  copy(force.torque, tick.t_T_W);
  copy(force.F_spring, tick.F_spring_W);
  copy(force.F_damping, tick.F_damping_W);
}

// Touch by touch, the strongest first.
void Cycle::record_touches(const contact::ContactSet& contacts, double stiffness_scale) noexcept {
  std::array<std::pair<double, int>, contact::kMaxContacts> order;
  for (int i = 0; i < contacts.size; ++i) {
    const contact::Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    order[static_cast<std::size_t>(i)] = {-stiffness_scale * c.normal.dot(c.material.K.cwiseProduct(c.delta_x)), i};
  }
  std::sort(order.begin(), order.begin() + contacts.size);
  Tick& tick = out_.tick;
  for (int k = 0; k < std::min(contacts.size, kTouches); ++k) {
    const auto& [minus_force, i] = order[static_cast<std::size_t>(k)];
    const contact::Contact& c = contacts.contact[static_cast<std::size_t>(i)];
    tick.touch_sphere[k] = c.sphere;
    tick.touch_object[k] = c.object;
    tick.touch_force[k] = -minus_force;
    Vec3::Map(tick.p_WC + 3 * static_cast<std::ptrdiff_t>(k)) = c.p_C;
  }
}

void Cycle::record_leader() noexcept {
  Tick& tick = out_.tick;
  const LeaderCommand& command = out_.leader;
  copy(leader_state_.q, tick.q);
  copy(leader_state_.v, tick.v);
  copy(command.hold() + command.act(), tick.tau);
  copy(command.tau_force, tick.tau_force);
  copy(command.tau_gravity, tick.tau_gravity);
  copy(command.tau_platform, tick.tau_platform);
  copy(command.tau_friction, tick.tau_friction);
  copy(command.tau_limits, tick.tau_limits);
  copy(command.F_law_L.f, tick.F_law_L);
  tick.F_neglected = command.F_neglected;
  tick.gripper = leader_state_.gripper;
  copy(X_LH_.p, tick.p_LH);
  copy(X_LH_.R, tick.quat_LH);
  copy(V_LH_.v, tick.v_LH);
}

}  // namespace palpate::loop
