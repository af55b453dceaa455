// What every stage reports of a tick: bits of status, and the sources to which energy is booked.
#pragma once

#include <span>

namespace palpate {

/// Bits of the signal `status`.
enum Status : unsigned {
  kOk = 0,
  kForceCapped = 1u << 0,        ///< the magnitude cap cut the force
  kRateCapped = 1u << 1,         ///< the rate cap cut the force
  kLeaderStale = 1u << 2,        ///< leader state too old: force ramps to zero
  kFollowerStale = 1u << 3,      ///< follower state too old: force ramps to zero
  kNotFinite = 1u << 4,          ///< a NaN, infinity or state beyond a million was stopped: force ramps to zero
  kTorqueLimited = 1u << 5,      ///< a joint torque reached its drive limit
  kIkFailed = 1u << 6,           ///< the follower could not reach the goal: it holds
  kClutched = 1u << 7,           ///< pedal pressed
  kNotFollowing = 1u << 8,       ///< teleoperation is off
  kHandSlipped = 1u << 9,        ///< the grip's force limit was reached (simulated hand)
  kSingular = 1u << 10,          ///< the leader can hardly move in some direction: what divides by it is damped
  kTooFast = 1u << 11,           ///< inertia and Coriolis forces that the control law leaves out are no longer small
  kNoLoadCell = 1u << 12,        ///< the control law needs the hand's measured force and has none
  kPassivity = 1u << 13,         ///< the passivity controller withholds force that the port could not pay for
  kNoTorques = 1u << 14,         ///< the follower's torques are missing or impossible: no force is estimated
  kGuided = 1u << 20,            ///< a guidance fixture applies a force
  kGoalCorrected = 1u << 21,     ///< a hard fixture corrects the commanded tool goal
  kGuidanceConflict = 1u << 22,  ///< hard fixtures contradict each other: one is relaxed, or the goal stays in place
  kFrameLost = 1u << 16,         ///< the frame of a fixture was never received, or timed out: the fixture fades out
  // Devices on a network (loop/crtk_cycle.hpp). The first two are states of operation. The others are faults: the force
  // is zero within 30 ms.
  kNoOperator = 1u << 17,    ///< nobody is at the console
  kNotEnabled = 1u << 18,    ///< an arm is not enabled and homed
  kFrameUnsure = 1u << 15,   ///< the arm may read wrenches in another frame, or not compensate its own weight
  kBadStamp = 1u << 19,      ///< a stamp was zero, which means invalid, or far from this machine's clock
  kClockJumped = 1u << 23,   ///< this machine's clock, or the device's
  kJumped = 1u << 24,        ///< a pose moved faster than anybody can
  kSecondWriter = 1u << 25,  ///< another node commands the same arm
  kOtherTeleop = 1u << 26,   ///< a teleoperation other than Palpate's is on
  kSlow = 1u << 27,          ///< the leader reports its state too rarely for the rate of the cycle
  kStalled = 1u << 28,       ///< the cycle itself was late
  kGuarded = 1u << 29,       ///< the guardian has taken over, or is missing
  kLagging = 1u << 30,       ///< the follower does not follow its goal
  kSettling = 1u << 31,      ///< after a fault: everything is good again, but not yet for long enough
};

/// One bit of Status, for people.
struct StatusWords {
  const char* name;
  unsigned bit;
  const char* words;
};

/// Every bit of Status, the gravest first.
std::span<const StatusWords> status_words() noexcept;

/// Sources to which the energy of the wanted force is booked: the scene's objects by their index, guidance, and last
/// everything else.
inline constexpr int kSources = 17;
inline constexpr int kGuidanceSource = kSources - 2;

}  // namespace palpate
