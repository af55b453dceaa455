// Status bits that the stages report in every tick, and the sources that the energy ledger distinguishes.
#pragma once

#include <cstdint>
#include <span>

namespace palpate {

/// Bits of the recorded signal `status`.
enum Status : unsigned {
  kOk = 0,
  kForceCapped = 1u << 0,     ///< the magnitude cap reduced the force
  kRateCapped = 1u << 1,      ///< the rate cap reduced the force
  kLeaderStale = 1u << 2,     ///< the leader state is too old: the force ramps to zero
  kFollowerStale = 1u << 3,   ///< the follower state is too old: the force ramps to zero
  kNotFinite = 1u << 4,       ///< a NaN, an infinity or a value beyond a million was stopped: the force ramps to zero
  kTorqueLimited = 1u << 5,   ///< a joint torque reached its drive limit
  kIkFailed = 1u << 6,        ///< the follower cannot reach the goal and goes to the nearest pose
  kClutched = 1u << 7,        ///< the clutch pedal is pressed
  kNotFollowing = 1u << 8,    ///< teleoperation is off
  kHandSlipped = 1u << 9,     ///< the simulated hand slipped: the force limit of its grip was reached
  kSingular = 1u << 10,       ///< the leader is near a singularity: the inverse of its dynamics is damped
  kTooFast = 1u << 11,        ///< the inertia and Coriolis forces that the control law neglects are no longer small
  kNoLoadCell = 1u << 12,     ///< the control law needs the measured force of the hand, but no load cell reports it
  kPassivity = 1u << 13,      ///< the passivity controller reduces the force, because the energy at the port is spent
  kNoTorques = 1u << 14,      ///< the follower's torques are missing or implausible: no force is estimated
  kGuided = 1u << 20,         ///< a guidance fixture applies a force
  kGoalCorrected = 1u << 21,  ///< a hard fixture corrects the commanded tool goal
  kGuidanceConflict = 1u << 22,  ///< hard fixtures contradict each other: one is relaxed, or the goal stays in place
  kFrameLost = 1u << 16,         ///< a live frame was never received, or timed out: fixtures and objects in it fade out
  // Devices on a network (loop/crtk_cycle.hpp). kNoOperator and kNotEnabled are states of operation. The others are
  // faults, which reduce the force to zero within 30 ms.
  kNoOperator = 1u << 17,    ///< no operator is at the console
  kNotEnabled = 1u << 18,    ///< an arm is not enabled or not homed
  kFrameUnsure = 1u << 15,   ///< the arm may interpret wrenches in another frame, or may not compensate its weight
  kBadStamp = 1u << 19,      ///< a time stamp was zero, which means invalid, or not finite
  kClockJumped = 1u << 23,   ///< the clock of this machine or of a device jumped
  kJumped = 1u << 24,        ///< a measured pose moved faster than a hand can
  kSecondWriter = 1u << 25,  ///< another node commands the same arm
  kOtherTeleop = 1u << 26,   ///< another teleoperation than Palpate's is active
  kSlow = 1u << 27,          ///< the leader reports its state too rarely for the rate of the cycle
  kStalled = 1u << 28,       ///< the cycle was late by more than the allowed age of a state
  kGuarded = 1u << 29,       ///< the guardian process has taken over, or is missing
  kLagging = 1u << 30,       ///< the follower stays far behind its goal
  kSettling = 1u << 31,      ///< after a fault: all signals are good again, but not yet for long enough
};

/// Further bits of the recorded signal `status`, which has 64: of soft bodies.
enum SoftStatus : std::uint64_t {
  kSoftFrozen = 1ull << 32,  ///< a soft body diverged: its force goes to zero and returns by a ramp
  kSoftLate = 1ull << 33,    ///< the thread of a soft body is late: its surface stands still meanwhile
};

/// Further bits of the recorded signal `status`: of devices on a network (loop/crtk_cycle.hpp). All are faults.
enum DeviceStatus : std::uint64_t {
  kTwoSources = 1ull << 34,       ///< several nodes publish one of the inputs
  kNoListener = 1ull << 35,       ///< nobody receives the wrenches
  kClockOffset = 1ull << 36,      ///< stamps are far from this machine's clock, or states take as long to arrive
  kNotRotation = 1ull << 37,      ///< a quaternion does not have the norm 1
  kTooFar = 1ull << 38,           ///< a position is farther away than any arm reaches
  kStreamsDisagree = 1ull << 39,  ///< the reported velocity is not that of the reported poses
  kBaseMoved = 1ull << 40,        ///< the frame in which an arm reports its pose is another one than at the start
  kAlternating = 1ull << 41,      ///< poses jump to and fro
};

/// Further bits of the recorded signal `status`: of the energy account.
enum EnergyStatus : std::uint64_t {
  kDeficit = 1ull << 42,  ///< the hand has got more energy than the passivity layer allows: bounds were exceeded
};

/// Name and description of one status bit, for records and reports.
struct StatusDescription {
  const char* name;         ///< identifier, for example "force_capped"
  std::uint64_t bit;        ///< value of the enumerator
  const char* description;  ///< description for the operator, in English
};

/// All status bits, the most severe first.
std::span<const StatusDescription> status_descriptions() noexcept;

/// Number of sources to which the ledger attributes the energy of the commanded force: the first objects of the scene
/// by index, then guidance, then everything else.
inline constexpr int kSources = 17;
/// Index of guidance among the sources.
inline constexpr int kGuidanceSource = kSources - 2;

}  // namespace palpate
