// The states of a session and the one table of their transitions. Every loop runs the machine in its cycle; Python, the
// documentation and the tests read the same table.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::loop {

/// State of a session. The hand moves the tool and receives forces in `following` alone.
enum class SessionState : std::uint8_t {
  off,
  powered,
  homing,
  homed,
  aligning,
  following,
  clutched,
  camera,
  hold,
  fault,
  recover,
  executing,
};
inline constexpr std::size_t kSessionStates = 12;

/// Cause of a transition: a request of a person (power_on .. recover), or a measurement.
enum class SessionCause : std::uint8_t {
  power_on,
  power_off,
  home,
  follow,
  stop,
  clutch,
  unclutch,
  camera,
  uncamera,
  hold,
  resume,
  recover,
  at_home,
  not_home,
  aligned,
  fault,
  settled,
  execute,
  ended,
};
inline constexpr std::size_t kSessionCauses = 19;

/// What a session is told in one tick: levels, not events, so that no message can be lost.
struct SessionInput {
  bool power = true;    ///< power is requested, and the arms have it
  bool home = true;     ///< homing is requested
  bool at_home = true;  ///< both arms report that they are homed
  bool follow = true;   ///< teleoperation is requested, and an operator is at the console
  bool aligned = true;  ///< the orientation of the handle agrees with that of the tool, within the tolerance
  bool clutch = false;  ///< clutch pedal
  bool camera = false;  ///< camera pedal
  bool hold = false;    ///< a hold is requested
  bool fault = false;   ///< a state of an arm is missing or wrong
  bool recover = true;  ///< the operator, or the scene, agrees to leave a fault
  bool settled = true;  ///< no fault has occurred for the time that the loop demands

  bool execute = false;  ///< a planned motion waits, moves or pauses
  bool moving = false;   ///< a planned motion is not yet at rest
};

/// One row of the table: in the state `from`, the cause leads to the state `to`.
struct SessionTransition {
  SessionState from;
  SessionCause cause;
  SessionState to;
};

/// Name and description of a state or of a cause.
struct SessionWord {
  const char* name;
  const char* description;
  bool request = false;  ///< a cause: true for a request of a person, false for a measurement
};

/// All transitions. In a state, the first row whose cause holds is taken.
std::span<const SessionTransition> session_transitions() noexcept;
/// Names and descriptions, in the order of SessionState and of SessionCause.
std::span<const SessionWord> session_states() noexcept;
std::span<const SessionWord> session_causes() noexcept;

/// The state machine of a session.
class SessionMachine {
 public:
  /// Takes every transition of the table that the input allows, one after the other: arms that are ready follow in the
  /// first tick. Returns the new state.
  SessionState step(const SessionInput& in) noexcept;
  [[nodiscard]] SessionState state() const noexcept { return state_; }

 private:
  SessionState state_ = SessionState::off;
};

}  // namespace palpate::loop
