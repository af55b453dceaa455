// One tick of a session: every signal of the paper's Fig 3, one row of the record.
// The table below is the only list of signals: record, report, viewer and numpy read it.
#pragma once

#include <cstddef>
#include <span>

namespace palpate::loop {

/// Bits of Tick::status.
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
  kNoLoadCell = 1u << 12,        ///< the control law wants the hand's force and does not get it
  kPassivity = 1u << 13,         ///< the passivity controller withholds force that the port could not pay for
  kNoTorques = 1u << 14,         ///< the follower's torques are missing or impossible: no force is estimated
  kGuided = 1u << 20,            ///< a fixture of guidance pulls
  kGoalCorrected = 1u << 21,     ///< a hard fixture keeps the tool's goal from where the hand sends it
  kGuidanceConflict = 1u << 22,  ///< hard fixtures contradict each other: one gave way, or the goal stays where it was
  // Of devices on a network (crtk_cycle.hpp). All but the first two are faults: the force is zero within 30 ms.
  kNoOperator = 1u << 17,    ///< nobody is at the console
  kNotEnabled = 1u << 18,    ///< an arm is not enabled and homed
  kFrameLost = 1u << 16,     ///< a fixture's frame was never told, or not for longer than its patience: it fades out
  kFrameUnsure = 1u << 15,   ///< the arm may read wrenches in another frame, or not carry its own weight
  kBadStamp = 1u << 19,      ///< a stamp was zero, which says not valid, or far from our clock
  kClockJumped = 1u << 23,   ///< ours, or the device's
  kJumped = 1u << 24,        ///< a pose moved faster than anybody can
  kSecondWriter = 1u << 25,  ///< somebody else commands the same arm
  kOtherTeleop = 1u << 26,   ///< a teleoperation that is not ours is on
  kSlow = 1u << 27,          ///< the leader tells its state too rarely for the rate of the cycle
  kStalled = 1u << 28,       ///< the cycle itself was late
  kGuarded = 1u << 29,       ///< the guardian has taken over, or is not there
  kLagging = 1u << 30,       ///< the follower does not follow its goal
  kSettling = 1u << 31,      ///< after a fault: all is well, but not yet for long enough
};

/// Touches of a tick that are told one by one.
inline constexpr int kTouches = 16;

/// Entries for what a force comes from: the scene's objects by their index, guidance, and the last one for all the
/// rest.
inline constexpr int kSources = 17;
inline constexpr int kGuidanceSource = kSources - 2;

struct Tick {
  double t;                        // time of the tick [s]
  double status;                   // bits of Status
  double q[7];                     // leader joints, measured [rad]
  double v[7];                     // leader joint velocities, estimated [rad/s]
  double tau[7];                   // commanded joint torque, sum of the terms below [N m]
  double tau_force[7];             // J^T F
  double tau_gravity[7];           // G_hat(q)
  double tau_platform[7];          // joint-4 controller
  double tau_friction[7];          // compensates friction
  double tau_limits[7];            // soft stops
  double F_law_L[3];               // what the control law adds to F_H_L, at the handle [N]
  double F_neglected;              // inertia and Coriolis force that it leaves to the hand, estimated [N]
  double gripper;                  // pinch [rad]
  double p_LH[3];                  // handle in the leader base [m]
  double quat_LH[4];               // w x y z
  double v_LH[3];                  // handle velocity in the leader base [m/s]
  double q_follower[7];            // follower joints, measured [rad, m]
  double tau_follower[7];          // torques of the follower's drives, where they are measured [N m, N]
  double jaw;                      // [rad]
  double p_WT_goal[3];             // tool goal: from the mapping, corrected by hard fixtures [m]
  double p_WT[3];                  // tool tip x, measured [m]
  double quat_WT[4];               // w x y z
  double p_WP[3];                  // proxy x_d of the strongest contact; the tool tip when free [m]
  double normal[3];                // of the strongest contact; zero when free
  double delta_x[3];               // deflection x_d - x [m]
  double depth;                    // [m]
  double contacts;                 // touches: pairs of a sphere of the tool and an object
  double touch_sphere[kTouches];   // of each touch, the strongest first: which sphere; 0 is the one on the tip
  double touch_object[kTouches];   // which object; zero beyond `contacts`, as all of these
  double touch_force[kTouches];    // spring force along the normal [N]
  double p_WC[3 * kTouches];       // where its proxy touches the surface [m]
  double F_T_W[3];                 // force law's output, environment on tool, before the stability stage [N]
  double t_T_W[3];                 // its torque about the tool tip [N m]
  double F_spring_W[3];            // K delta_x
  double F_damping_W[3];           // -B xdot
  double F_estimate_W[3];          // environment on tool, from the follower's drive torques, where asked for [N]
  double F_touch_W[3];             // what the objects do to the tool of a driven follower: the truth (simulated) [N]
  double F_guidance_W[3];          // of the fixtures of guidance, as a force on the tool [N]
  double t_guidance_W[3];          // their torque about the tool tip [N m]
  double guidance_fixture;         // the one that pulls most, by its index; -1 when none does
  double guidance_gap;             // of it, or of the nearest: below zero by how much it is not as wanted [m, rad]
  double quat_WT_asked[4];         // attitude that the hand asks of the tool, before hard fixtures turn it: w x y z
  double p_correction_W[3];        // of the tool goal by hard fixtures: the given goal minus the mapped one [m]
  double F_H_L[3];                 // commanded on the hand, leader base ("spatial", green) [N]
  double t_H_L[3];                 // moment commanded on the hand, leader base [N m]
  double F_H_H[3];                 // the same in the handle frame ("body", red) [N]
  double F_cell_L[3];              // load cell between hand and handle: force of the arm on the hand [N]
  double p_hand_L[3];              // the hand's intended position [m]
  double energy_port;              // energy the rendered force took from the hand; below zero: it generated [J]
  double energy_spring;            // stored in the contacts' springs [J]
  double energy_damping;           // dissipated by the damping term [J]
  double energy_cut;               // what the caps withheld [J]
  double energy_passivity;         // what the passivity controller withheld [J]
  double energy_low_pass;          // what the low-pass withheld [J]
  double energy_coupling;          // what the virtual coupling withheld [J]
  double energy_source[kSources];  // wanted by each object, by guidance, and last by all the rest, before the stage [J]
  double energy_stored;            // what the passivity layer may still give back [J]
  double energy_lent;              // by fixtures, where they were switched on: the hand need not have put it in [J]
  double energy_reserved;          // of it, most that the wrenches on their way may cost [J]
  double lag_ms[4];                // of virtual coupling, low-pass, passivity controller, caps [ms]
  double cycle_us;                 // compute time of the haptic cycle [us]      (not deterministic)
  double lateness_us;              // start of the tick after its deadline [us]   (not deterministic)
};

/// One row of the table: a signal's name, size and meaning.
struct Signal {
  const char* name;
  std::size_t offset;  ///< bytes into Tick
  std::size_t size;    ///< doubles
  const char* unit;
  const char* frame;  ///< monogram letter, empty when there is none
  const char* doc;
  bool deterministic;  ///< false: depends on the machine, kept out of a lockstep record
  const char* stage;   ///< that speaks it: the first word of its channel
};

/// One bit of Tick::status, for people.
struct StatusWords {
  const char* name;
  unsigned bit;
  const char* words;
};

std::span<const Signal> signals() noexcept;
/// Every bit of Status, the gravest first.
std::span<const StatusWords> status_words() noexcept;

}  // namespace palpate::loop
