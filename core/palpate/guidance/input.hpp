// Options and input of the stage `guidance`.
#pragma once

#include "palpate/guidance/follower_model.hpp"
#include "palpate/types/motion.hpp"

namespace palpate::guidance {

/// Options of the stage.
struct Options {
  double force_rate = 20.0;    ///< limit of force changes that no motion explains: a switch, an edit [N/s]
  double moment_rate = 0.35;   ///< the same limit for moments [N m/s]
  double return_speed = 0.05;  ///< speed of the goal without motion of the hand, e.g. out of a new region [m/s]
  double reserve = 5e-5;       ///< distance that hard fixtures keep between goal and border [m]
  ServoOptions servo;          ///< response of the follower to its goal
};

/// Input of the stage at every tick, in W.
struct Input {
  double t = 0.0;        ///< time of the tick [s]
  ToolGoal goal;         ///< commanded goal from the mapping; while it is not engaged, the hand feels no fixture
  ToolState tool;        ///< measured state of the tool
  ToolForce tool_force;  ///< contact force on the tool
  Handle handle;         ///< used: the operator's force, and whether the device renders damping
  double pedal = 1.0;    ///< guidance pedal, 0-1
};

}  // namespace palpate::guidance
