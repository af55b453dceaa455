#include "palpate/types/status.hpp"

#include <array>

namespace palpate {
namespace {

constexpr std::array kStatusDescriptions = {
    StatusDescription{"guarded", kGuarded, "the guardian has taken over, or is gone: the force stays zero"},
    StatusDescription{"second_writer", kSecondWriter,
                      "another program commands the same arm: no force until one of them ends"},
    StatusDescription{"other_teleop", kOtherTeleop,
                      "another teleoperation is on, or not yet known to be off: nothing is sent"},
    StatusDescription{"two_sources", kTwoSources,
                      "several programs publish one input of this node: no force until one is left"},
    StatusDescription{"no_listener", kNoListener, "nobody receives the wrenches: no force"},
    StatusDescription{"base_moved", kBaseMoved, "an arm reports its pose in another frame than at the start: no force"},
    StatusDescription{
        "frame_unsure", kFrameUnsure,
        "the arm may not know the frame of the wrench, or another program changed it or the gravity compensation: "
        "the force goes to zero"},
    StatusDescription{"jumped", kJumped, "a pose jumped, faster than any hand: the force goes to zero"},
    StatusDescription{"clock_jumped", kClockJumped, "a clock jumped: the force goes to zero"},
    StatusDescription{"alternating", kAlternating, "poses jump to and fro: the force goes to zero"},
    StatusDescription{"clock_offset", kClockOffset,
                      "stamps are far from this machine's clock, or states take as long to arrive: no force"},
    StatusDescription{"bad_stamp", kBadStamp, "a stamp was zero (not valid): the force goes to zero"},
    StatusDescription{"stalled", kStalled,
                      "the cycle was late by more than a state may be old: the force goes to zero"},
    StatusDescription{"not_finite", kNotFinite,
                      "a number was not finite, or beyond a million: the force ramps to zero"},
    StatusDescription{"not_rotation", kNotRotation, "a quaternion did not have the norm 1: the force goes to zero"},
    StatusDescription{"too_far", kTooFar,
                      "a position was farther away than any arm reaches (millimetres?): the force goes to zero"},
    StatusDescription{"streams_disagree", kStreamsDisagree,
                      "the velocity that the leader reports is not that of its poses: the force goes to zero"},
    StatusDescription{"leader_stale", kLeaderStale, "the leader is silent: the force ramps to zero"},
    StatusDescription{"follower_stale", kFollowerStale, "the follower is silent: the force ramps to zero"},
    StatusDescription{"soft_frozen", kSoftFrozen,
                      "soft tissue became unstable: its force goes to zero and returns within half a second; if this "
                      "repeats, shorten its time step (key step of tissue)"},
    StatusDescription{"soft_late", kSoftLate,
                      "the thread of a soft tissue is late: it stands still, and after 50 ms its force goes to zero "
                      "until the thread goes on; coarser tetrahedra (key resolution of tissue) need less time"},
    StatusDescription{"lagging", kLagging, "the follower stays far behind its goal: it is let go"},
    StatusDescription{"slow", kSlow,
                      "the leader reports its state too rarely, or too often, for the rate of the cycle: no force"},
    StatusDescription{"not_enabled", kNotEnabled, "an arm is not enabled and homed: no force"},
    StatusDescription{"no_operator", kNoOperator, "nobody is at the console: no force"},
    StatusDescription{"settling", kSettling, "all is well again, but not yet for long enough: no force yet"},
    StatusDescription{"not_following", kNotFollowing, "not following: the instrument stands still"},
    StatusDescription{"clutched", kClutched, "clutched: the hand moves freely, the instrument stays"},
    StatusDescription{"force_capped", kForceCapped, "force capped"},
    StatusDescription{"rate_capped", kRateCapped, "force rises no faster than its cap allows"},
    StatusDescription{"energy_deficit", kDeficit,
                      "the hand has got more energy than the passivity layer allows: the hand moved faster than "
                      "stability.acceleration, or the loop is slower or less even than before; forces only resist the "
                      "motion until the hand's work has covered the deficit"},
    StatusDescription{"passivity", kPassivity, "passivity: the force is held back to what the hand has put in"},
    StatusDescription{"torque_limited", kTorqueLimited, "a motor is at its torque limit"},
    StatusDescription{"no_load_cell", kNoLoadCell, "no load cell: the control law renders as stiffness control does"},
    StatusDescription{"no_torques", kNoTorques,
                      "the follower's torques are missing or impossible: no force is estimated from them"},
    StatusDescription{"singular", kSingular, "the leader is nearly stretched: its dynamics are damped"},
    StatusDescription{"too_fast", kTooFast, "fast motion: the hand feels the arm's inertia in addition to the force"},
    StatusDescription{"guidance_conflict", kGuidanceConflict, "fixtures contradict each other: one of them gives way"},
    StatusDescription{"frame_lost", kFrameLost,
                      "a live frame has no known pose, or an old one: fixtures and objects in it are inactive"},
    StatusDescription{"goal_corrected", kGoalCorrected, "a hard fixture holds the instrument back"},
    StatusDescription{"ik_failed", kIkFailed, "the instrument cannot reach its goal: it goes to the nearest pose"},
    StatusDescription{"hand_slipped", kHandSlipped, "the handle slips out of the hand's grip"},
    StatusDescription{"guided", kGuided, "a fixture of guidance pulls"},
};

}  // namespace

std::span<const StatusDescription> status_descriptions() noexcept { return kStatusDescriptions; }

}  // namespace palpate
