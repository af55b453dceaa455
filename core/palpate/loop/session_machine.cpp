#include "palpate/loop/session_machine.hpp"

#include <array>

namespace palpate::loop {
namespace {

using S = SessionState;
using C = SessionCause;

constexpr std::array<SessionWord, kSessionStates> kStates{{
    {"off", "no power: the arms report no state, or are switched off"},
    {"powered", "the arms have power and hold; they do not know their joint positions yet"},
    {"homing", "the arms find their joint positions and move to their home position"},
    {"homed", "the arms are ready; the tool holds, and the hand is free"},
    {"aligning", "the handle turns, or is turned, to the orientation of the tool; the tool holds"},
    {"following", "the tool follows the hand, and the hand receives forces"},
    {"clutched", "clutch pedal: the hand moves freely, the tool holds"},
    {"camera", "camera pedal: the hands move the endoscope, the tools hold"},
    {"hold", "everything holds by request; gravity stays compensated"},
    {"fault", "a state of an arm is missing or wrong: the force ramps to zero, the tool holds"},
    {"recover", "the cause of the fault is gone, but not yet for long enough"},
    {"executing", "a planned motion moves the tool; the hand is free"},
}};

constexpr std::array<SessionWord, kSessionCauses> kCauses{{
    {"power_on", "switch the arms on", true},
    {"power_off", "switch the arms off", true},
    {"home", "home the arms", true},
    {"follow", "let the tool follow the hand; the operator must be at the console", true},
    {"stop", "end teleoperation, or leave the console", true},
    {"clutch", "press the clutch pedal", true},
    {"unclutch", "release the clutch pedal", true},
    {"camera", "press the camera pedal", true},
    {"uncamera", "release the camera pedal", true},
    {"hold", "hold everything where it is", true},
    {"resume", "end the hold", true},
    {"recover", "leave the fault, once its cause is gone", true},
    {"at_home", "both arms are homed"},
    {"not_home", "an arm is no longer homed"},
    {"aligned", "handle and tool have the same orientation, within the tolerance"},
    {"fault", "a state of an arm is missing, too old or wrong"},
    {"settled", "no fault for the time that the loop demands"},
    {"execute", "a planned motion was given to the session (`session.execute`)"},
    {"ended", "the planned motion is over, and the tool rests"},
}};

// Power and faults come first in every state, then a hold, then what the state is for.
constexpr SessionTransition kTransitions[] = {
    {S::off, C::power_on, S::powered},

    {S::powered, C::power_off, S::off},
    {S::powered, C::fault, S::fault},
    {S::powered, C::hold, S::hold},
    {S::powered, C::home, S::homing},

    {S::homing, C::power_off, S::off},
    {S::homing, C::fault, S::fault},
    {S::homing, C::hold, S::hold},
    {S::homing, C::at_home, S::homed},

    {S::homed, C::power_off, S::off},
    {S::homed, C::fault, S::fault},
    {S::homed, C::hold, S::hold},
    {S::homed, C::not_home, S::powered},
    {S::homed, C::execute, S::executing},
    {S::homed, C::follow, S::aligning},

    {S::aligning, C::power_off, S::off},
    {S::aligning, C::fault, S::fault},
    {S::aligning, C::hold, S::hold},
    {S::aligning, C::not_home, S::powered},
    {S::aligning, C::stop, S::homed},
    {S::aligning, C::camera, S::camera},
    {S::aligning, C::clutch, S::clutched},
    {S::aligning, C::aligned, S::following},

    {S::following, C::power_off, S::off},
    {S::following, C::fault, S::fault},
    {S::following, C::hold, S::hold},
    {S::following, C::not_home, S::powered},
    {S::following, C::stop, S::homed},
    {S::following, C::camera, S::camera},
    {S::following, C::clutch, S::clutched},
    {S::following, C::execute, S::executing},

    {S::clutched, C::power_off, S::off},
    {S::clutched, C::fault, S::fault},
    {S::clutched, C::hold, S::hold},
    {S::clutched, C::not_home, S::powered},
    {S::clutched, C::stop, S::homed},
    {S::clutched, C::camera, S::camera},
    {S::clutched, C::unclutch, S::aligning},

    {S::camera, C::power_off, S::off},
    {S::camera, C::fault, S::fault},
    {S::camera, C::hold, S::hold},
    {S::camera, C::not_home, S::powered},
    {S::camera, C::stop, S::homed},
    {S::camera, C::uncamera, S::aligning},

    {S::executing, C::power_off, S::off},
    {S::executing, C::fault, S::fault},
    {S::executing, C::hold, S::hold},
    {S::executing, C::not_home, S::powered},
    {S::executing, C::ended, S::aligning},

    {S::hold, C::power_off, S::off},
    {S::hold, C::fault, S::fault},
    {S::hold, C::resume, S::powered},

    {S::fault, C::power_off, S::off},
    {S::fault, C::recover, S::recover},

    {S::recover, C::power_off, S::off},
    {S::recover, C::fault, S::fault},
    {S::recover, C::settled, S::powered},
};

/// True if the cause holds in this tick.
bool holds(SessionCause cause, const SessionInput& in) noexcept {
  const bool ended = !in.execute && !in.moving;
  const std::array<bool, kSessionCauses> now{
      in.power,   !in.power,   in.home,    in.follow, !in.follow, in.clutch,
      !in.clutch, in.camera,   !in.camera, in.hold,   !in.hold,   in.recover && !in.fault,
      in.at_home, !in.at_home, in.aligned, in.fault,  in.settled, in.execute,
      ended,
  };
  return now[static_cast<std::size_t>(cause)];
}

}  // namespace

std::span<const SessionTransition> session_transitions() noexcept { return kTransitions; }
std::span<const SessionWord> session_states() noexcept { return kStates; }
std::span<const SessionWord> session_causes() noexcept { return kCauses; }

SessionState SessionMachine::step(const SessionInput& in) noexcept {
  for (std::size_t taken = 0; taken < kSessionStates; ++taken) {
    const SessionState before = state_;
    for (const SessionTransition& row : kTransitions) {
      if (row.from != before || !holds(row.cause, in)) continue;
      state_ = row.to;
      break;
    }
    if (state_ == before) break;
  }
  return state_;
}

}  // namespace palpate::loop
