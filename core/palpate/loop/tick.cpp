#include "palpate/loop/tick.hpp"

#include <array>

namespace palpate::loop {
namespace {

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): a field's name, offset and size, written once
#define SIGNAL(stage, field, unit, frame, doc, deterministic)                                                    \
  Signal {                                                                                                       \
    #field, offsetof(Tick, field), sizeof(Tick::field) / sizeof(double), unit, frame, doc, deterministic, #stage \
  }

constexpr std::array kSignals = {
    SIGNAL(loop, t, "s", "", "time of the tick", true),
    SIGNAL(stability, status, "bits", "", "what the safety layer did", true),
    SIGNAL(leader, q, "rad", "", "leader joints, measured", true),
    SIGNAL(leader, v, "rad/s", "", "leader joint velocities, estimated", true),
    SIGNAL(torque, tau, "N m", "", "commanded joint torque, the sum of its terms", true),
    SIGNAL(torque, tau_force, "N m", "", "J^T (F_H_L + F_law_L): renders the force", true),
    SIGNAL(torque, tau_gravity, "N m", "", "G_hat(q): holds the arm up", true),
    SIGNAL(torque, tau_platform, "N m", "", "joint-4 null-space controller", true),
    SIGNAL(torque, tau_friction, "N m", "", "compensates the arm's friction", true),
    SIGNAL(torque, tau_limits, "N m", "", "soft stops before the joint limits", true),
    SIGNAL(torque, F_law_L, "N", "L", "what the control law adds to F_H_L, at the handle", true),
    SIGNAL(torque, F_neglected, "N", "", "inertia and Coriolis force that the control law leaves to the hand", true),
    SIGNAL(leader, gripper, "rad", "", "pinch angle of the leader", true),
    SIGNAL(leader, p_LH, "m", "L", "handle position", true),
    SIGNAL(leader, quat_LH, "1", "L", "handle orientation, w x y z", true),
    SIGNAL(leader, v_LH, "m/s", "L", "handle velocity", true),
    SIGNAL(follower, q_follower, "rad|m", "", "follower joints, measured", true),
    SIGNAL(follower, tau_follower, "N m|N", "", "torques of the follower's drives, where they are measured", true),
    SIGNAL(follower, jaw, "rad", "", "jaw angle of the follower", true),
    SIGNAL(mapping, p_WT_goal, "m", "W", "tool goal from the mapping, corrected by hard fixtures", true),
    SIGNAL(follower, p_WT, "m", "W", "tool tip x, measured", true),
    SIGNAL(follower, quat_WT, "1", "W", "tool orientation, w x y z", true),
    SIGNAL(contact, p_WP, "m", "W", "proxy x_d; the tool tip when nothing is touched", true),
    SIGNAL(contact, normal, "1", "W", "surface normal, out of the obstacle; zero when free", true),
    SIGNAL(contact, delta_x, "m", "W", "deflection x_d - x, out of the obstacle", true),
    SIGNAL(contact, depth, "m", "", "penetration: deflection along the normal", true),
    SIGNAL(contact, contacts, "1", "", "touches: pairs of a sphere of the tool and an object", true),
    SIGNAL(contact, touch_sphere, "1", "", "which sphere, of each touch, the strongest first; 0 is on the tip", true),
    SIGNAL(contact, touch_object, "1", "", "which object, of each touch", true),
    SIGNAL(contact, touch_force, "N", "", "spring force along the normal, of each touch", true),
    SIGNAL(contact, p_WC, "m", "W", "where the proxy touches the surface, of each touch", true),
    SIGNAL(force, F_T_W, "N", "W", "force law: environment on tool, before the stability stage", true),
    SIGNAL(force, t_T_W, "N m", "W", "its torque about the tool tip", true),
    SIGNAL(force, F_spring_W, "N", "W", "K delta_x", true),
    SIGNAL(force, F_damping_W, "N", "W", "-B xdot", true),
    SIGNAL(force, F_estimate_W, "N", "W", "environment on tool, from the follower's drive torques", true),
    SIGNAL(follower, F_touch_W, "N", "W", "objects on the tool of a driven follower, the truth (simulated)", true),
    SIGNAL(guidance, F_guidance_W, "N", "W", "force of the fixtures of guidance on the tool", true),
    SIGNAL(guidance, t_guidance_W, "N m", "W", "their torque about the tool tip", true),
    SIGNAL(guidance, guidance_fixture, "1", "", "fixture that pulls most, by its index; -1 when none does", true),
    SIGNAL(guidance, guidance_gap, "m|rad", "", "of it, or of the nearest: below zero it is not as wanted", true),
    SIGNAL(guidance, quat_WT_asked, "1", "W", "attitude asked of the tool, before hard ones turn it, w x y z", true),
    SIGNAL(guidance, p_correction_W, "m", "W", "of the tool goal, by hard fixtures", true),
    SIGNAL(stability, F_H_L, "N", "L", "commanded on the hand, spatial frame", true),
    SIGNAL(stability, t_H_L, "N m", "L", "moment commanded on the hand, spatial frame", true),
    SIGNAL(stability, F_H_H, "N", "H", "commanded on the hand, body frame", true),
    SIGNAL(hand, F_cell_L, "N", "L", "load cell: force of the arm on the hand (simulated)", true),
    SIGNAL(hand, p_hand_L, "m", "L", "where the hand wants to be", true),
    SIGNAL(stability, energy_port, "J", "", "energy the rendered force took from the hand; below zero it generated",
           true),
    SIGNAL(stability, energy_spring, "J", "", "stored in the contact springs", true),
    SIGNAL(stability, energy_damping, "J", "", "dissipated by the damping term", true),
    SIGNAL(stability, energy_cut, "J", "", "withheld by the caps", true),
    SIGNAL(stability, energy_passivity, "J", "", "withheld by the passivity controller", true),
    SIGNAL(stability, energy_low_pass, "J", "", "withheld by the low-pass", true),
    SIGNAL(stability, energy_coupling, "J", "", "withheld by the virtual coupling", true),
    SIGNAL(stability, energy_source, "J", "",
           "wanted by each object, by guidance, and last by all the rest, before the stage", true),
    SIGNAL(stability, energy_stored, "J", "", "what the passivity layer may still give back", true),
    SIGNAL(stability, energy_lent, "J", "", "lent by fixtures that were switched on where the hand was", true),
    SIGNAL(stability, energy_reserved, "J", "", "of it, most that the wrenches on their way may cost", true),
    SIGNAL(stability, lag_ms, "ms", "", "of virtual coupling, low-pass, passivity controller, caps", true),
    SIGNAL(loop, cycle_us, "us", "", "compute time of the haptic cycle", false),
    SIGNAL(loop, lateness_us, "us", "", "start of the tick after its deadline", false),
};

#undef SIGNAL

constexpr std::array kStatusWords = {
    StatusWords{"guarded", kGuarded, "the guardian has taken over, or is gone: the force stays zero"},
    StatusWords{"second_writer", kSecondWriter, "somebody else commands the same arm: no force until one of them ends"},
    StatusWords{"other_teleop", kOtherTeleop,
                "another teleoperation is on, or not yet known to be off: nothing is sent"},
    StatusWords{"frame_unsure", kFrameUnsure,
                "the arm has not been told the frame of the wrench, or somebody changed it or gravity compensation: "
                "the force goes to zero"},
    StatusWords{"jumped", kJumped, "a pose jumped, faster than any hand: the force goes to zero"},
    StatusWords{"clock_jumped", kClockJumped, "a clock jumped: the force goes to zero"},
    StatusWords{"bad_stamp", kBadStamp, "a stamp was zero (not valid) or far from this machine's clock"},
    StatusWords{"stalled", kStalled, "the cycle was late by more than a state may be old: the force goes to zero"},
    StatusWords{"not_finite", kNotFinite, "a number was not finite, or beyond a million: the force ramps to zero"},
    StatusWords{"leader_stale", kLeaderStale, "the leader is silent: the force ramps to zero"},
    StatusWords{"follower_stale", kFollowerStale, "the follower is silent: the force ramps to zero"},
    StatusWords{"lagging", kLagging, "the follower stays far behind its goal: it is let go"},
    StatusWords{"slow", kSlow, "the leader tells its state too rarely for the rate of the cycle: no force"},
    StatusWords{"not_enabled", kNotEnabled, "an arm is not enabled and homed: no force"},
    StatusWords{"no_operator", kNoOperator, "nobody is at the console: no force"},
    StatusWords{"settling", kSettling, "all is well again, but not yet for long enough: no force yet"},
    StatusWords{"not_following", kNotFollowing, "not following: the instrument stands still"},
    StatusWords{"clutched", kClutched, "clutched: the hand moves freely, the instrument stays"},
    StatusWords{"force_capped", kForceCapped, "force capped"},
    StatusWords{"rate_capped", kRateCapped, "force rises no faster than its cap allows"},
    StatusWords{"passivity", kPassivity, "passivity: the force is held back to what the hand has put in"},
    StatusWords{"torque_limited", kTorqueLimited, "a motor is at its torque limit"},
    StatusWords{"no_load_cell", kNoLoadCell, "no load cell: the control law renders as stiffness control does"},
    StatusWords{"no_torques", kNoTorques, "the follower's torques are missing or impossible: no force is told by them"},
    StatusWords{"singular", kSingular, "the leader is nearly stretched: its dynamics are damped"},
    StatusWords{"too_fast", kTooFast, "fast motion: the hand feels the arm's inertia beside the force"},
    StatusWords{"guidance_conflict", kGuidanceConflict, "fixtures contradict each other: one of them gives way"},
    StatusWords{"frame_lost", kFrameLost,
                "the frame that a fixture is attached to is not told where it is: the fixture counts for nothing"},
    StatusWords{"goal_corrected", kGoalCorrected, "a hard fixture holds the instrument back"},
    StatusWords{"ik_failed", kIkFailed, "the instrument cannot reach further: it holds"},
    StatusWords{"hand_slipped", kHandSlipped, "the handle slips out of the hand's grip"},
    StatusWords{"guided", kGuided, "a fixture of guidance pulls"},
};

}  // namespace

std::span<const Signal> signals() noexcept { return kSignals; }

std::span<const StatusWords> status_words() noexcept { return kStatusWords; }

}  // namespace palpate::loop
