#include "palpate/loop/tick.hpp"

#include <array>

namespace palpate::loop {
namespace {

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): a field's name, offset and size, written once
#define SIGNAL(field, unit, frame, doc, deterministic) \
  Signal { #field, offsetof(Tick, field), sizeof(Tick::field) / sizeof(double), unit, frame, doc, deterministic }

constexpr std::array kSignals = {
    SIGNAL(t, "s", "", "time of the tick", true),
    SIGNAL(status, "bits", "", "what the safety layer did", true),
    SIGNAL(q, "rad", "", "leader joints, measured", true),
    SIGNAL(v, "rad/s", "", "leader joint velocities, estimated", true),
    SIGNAL(tau, "N m", "", "commanded joint torque, the sum of its terms", true),
    SIGNAL(tau_force, "N m", "", "J^T F: renders the force", true),
    SIGNAL(tau_gravity, "N m", "", "G_hat(q): holds the arm up", true),
    SIGNAL(tau_platform, "N m", "", "joint-4 null-space controller", true),
    SIGNAL(gripper, "rad", "", "pinch angle of the leader", true),
    SIGNAL(p_LH, "m", "L", "handle position", true),
    SIGNAL(quat_LH, "1", "L", "handle orientation, w x y z", true),
    SIGNAL(v_LH, "m/s", "L", "handle velocity", true),
    SIGNAL(q_follower, "rad|m", "", "follower joints, measured", true),
    SIGNAL(jaw, "rad", "", "jaw angle of the follower", true),
    SIGNAL(p_WT_goal, "m", "W", "tool goal from the mapping", true),
    SIGNAL(p_WT, "m", "W", "tool tip x, measured", true),
    SIGNAL(quat_WT, "1", "W", "tool orientation, w x y z", true),
    SIGNAL(p_WP, "m", "W", "proxy x_d; the tool tip when nothing is touched", true),
    SIGNAL(normal, "1", "W", "surface normal, out of the obstacle; zero when free", true),
    SIGNAL(delta_x, "m", "W", "deflection x_d - x, out of the obstacle", true),
    SIGNAL(depth, "m", "", "penetration: deflection along the normal", true),
    SIGNAL(contacts, "1", "", "number of objects touched", true),
    SIGNAL(F_T_W, "N", "W", "force law: environment on tool, before the stability stage", true),
    SIGNAL(F_spring_W, "N", "W", "K delta_x", true),
    SIGNAL(F_damping_W, "N", "W", "-B xdot", true),
    SIGNAL(F_H_L, "N", "L", "commanded on the hand, spatial frame", true),
    SIGNAL(F_H_H, "N", "H", "commanded on the hand, body frame", true),
    SIGNAL(F_cell_L, "N", "L", "load cell: force of the arm on the hand (simulated)", true),
    SIGNAL(p_hand_L, "m", "L", "where the hand wants to be", true),
    SIGNAL(energy_port, "J", "", "energy the rendered force took from the hand; below zero it generated", true),
    SIGNAL(energy_spring, "J", "", "stored in the contact springs", true),
    SIGNAL(energy_damping, "J", "", "dissipated by the damping term", true),
    SIGNAL(energy_cut, "J", "", "withheld by the caps", true),
    SIGNAL(cycle_us, "us", "", "compute time of the haptic cycle", false),
    SIGNAL(lateness_us, "us", "", "start of the tick after its deadline", false),
};

#undef SIGNAL

}  // namespace

std::span<const Signal> signals() noexcept { return kSignals; }

}  // namespace palpate::loop
