// Options of the stage `guidance`, and of roles, laws and policies of fixtures. A scene's file has their defaults.
#pragma once

#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// Options of the servo that moves the follower's joints to their goals.
struct ServoOptions {
  double bandwidth = -1.0;     ///< natural frequency [Hz]; 0: the joints follow without lag; negative: that of the
                               ///< simulated follower, or, with another follower, without lag
  double damping_ratio = 1.0;  ///< damping ratio zeta [-]
};

/// Options of the stage.
struct Options {
  double force_rate = 20.0;    ///< limit of force changes that no motion explains: a switch, an edit [N/s]
  double moment_rate = 0.35;   ///< the same limit for moments [N m/s]
  double return_speed = 0.05;  ///< speed of the goal without motion of the hand, e.g. out of a new region [m/s]
  double reserve = 5e-5;       ///< distance that hard fixtures keep between goal and border [m]
  ServoOptions servo;          ///< response of the follower to its goal
};

/// Throws std::invalid_argument naming an invalid option.
void check(const Options& options);

/// Options of all roles; each role reads its own.
struct RoleOptions {
  double margin = 0.0;  ///< guide, rcm: free distance; forbid, keep-in: clearance to the border; limit: widens it [m]
  double angle = 0.0;   ///< orient: free angle to the target [rad]
  Vec3 axis = Vec3::UnitZ();    ///< orient: axis of the tool that is aligned; rcm: direction of the shaft; in T
  std::string target = "axis";  ///< orient: along the geometry's `axis`, against its `normal`, or as its `frame`
  double speed = 0.0;           ///< limit: largest speed of the tool [m/s]; 0: unlimited
  double force = 0.0;  ///< limit: largest contact force [N]; 0: unlimited. Without speed and force: a workspace
};

/// Options of all laws; each law reads its own.
struct LawOptions {
  double K = 400.0;         ///< stiffness on the tool's side; the hand feels scale * force_scale * K [N/m]
  double B = 2.0;           ///< damping along the gradient [N s/m]
  double K_turn = 0.5;      ///< rotational stiffness [N m/rad]
  double B_turn = 0.005;    ///< rotational damping [N m s/rad]
  double force = 3.0;       ///< potential, optimise: largest force [N]
  double moment = 0.05;     ///< potential, optimise: largest moment [N m]
  double range = 0.01;      ///< distance to the border at which attraction ends, or at which potential and
                            ///< admittance begin to resist [m]
  double range_turn = 0.5;  ///< potential: the same for an angle [rad]
  double ratio = 0.1;       ///< admittance: speed across / speed along the free directions, at the same force [0-1]
};

/// Multiplies the authority by a factor that follows a measured value: 0 at `from`, 1 at `to`, linear in between.
/// `from` may be larger than `to`.
struct Ramp {
  enum class By {
    pedal,     ///< guidance pedal, 0-1
    distance,  ///< |gap| [m, rad]
    time,      ///< time since the fixture engaged [s]
    force,     ///< operator's force from a load cell; without a load cell the force of the fixture's law [N]
  };
  By by = By::pedal;
  double from = 0.0, to = 1.0;  ///< values at which the factor is 0 and 1, in the unit of `by`
};

/// When a fixture acts, and with how much authority.
struct Policy {
  bool hard = false;  ///< corrects the tool's goal as well: with authority 1 the tool never violates the constraint
  double authority = 1.0;  ///< 0-1, multiplied by the ramps
  int priority = 0;        ///< a fixture acts where those of higher priority leave the goal; hard fixtures come first
  double engage = std::numeric_limits<double>::infinity();   ///< the fixture engages when |gap| is below [m, rad]
  double release = std::numeric_limits<double>::infinity();  ///< and releases when |gap| is above [m, rad]
  double rise = 0.2;  ///< shortest time in which the authority rises from 0 to 1 [s]
  double fall = 0.2;  ///< shortest time in which the authority falls from 1 to 0 [s]
  std::vector<Ramp> ramps;
};

/// Default half angle of a cone that is given by its entry and its target [rad].
inline constexpr double kConeHalfAngle = 15.0 * std::numbers::pi / 180.0;

}  // namespace palpate::guidance
