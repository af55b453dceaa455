// Options and input of the stage `guidance`.
#pragma once

#include "palpate/guidance/follower_model.hpp"
#include "palpate/types/motion.hpp"

namespace palpate::guidance {

struct Options {
  double force_rate = 20.0;    ///< of changes that no motion explains: a switch, an edit, another priority [N/s]
  double moment_rate = 0.35;   ///< the same of moments [N m/s]
  double return_speed = 0.05;  ///< of the goal without motion of the hand: out of a region just forbidden [m/s]
  double reserve = 5e-5;       ///< distance that hard fixtures keep between goal and border [m]
  ServoOptions servo;          ///< of the follower behind its goal
};

/// Input of the stage at every tick. All in W.
struct Input {
  double t = 0.0;      ///< now [s]
  ToolGoal goal;       ///< commanded by the hand, from the mapping; while not engaged the hand feels nothing
  ToolState tool;      ///< measured
  Touch touch;         ///< what the tool touches
  Handle handle;       ///< its operator's force and whether it takes damping
  double pedal = 1.0;  ///< of guidance, 0-1
};

}  // namespace palpate::guidance
