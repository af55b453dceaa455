#include "palpate/types/status.hpp"

#include <array>

namespace palpate {
namespace {

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

std::span<const StatusWords> status_words() noexcept { return kStatusWords; }

}  // namespace palpate
