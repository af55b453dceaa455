// Stage `stability`: a chain of elements, each in a file of its own.
//
//   wanted -> virtual coupling -> low-pass -> caps, rate limit, watchdog -> passivity controller -> rendered
//
// The passivity controller and the drives' limits (stage `torque`) only reduce the wrench, in the same direction and
// without a ramp. rendered() reports what is left, so that the wrench returns by a ramp.
#pragma once

#include <limits>

#include "palpate/stability/coupling.hpp"
#include "palpate/stability/limiter.hpp"
#include "palpate/stability/low_pass.hpp"
#include "palpate/stability/passivity.hpp"
#include "palpate/types/damped_wrench.hpp"
#include "palpate/types/motion.hpp"
#include "palpate/types/spatial.hpp"
#include "palpate/types/status.hpp"

namespace palpate::stability {

/// Options of the stage.
struct Options : Caps {
  CouplingOptions coupling;
  LowPassOptions low_pass;
  PassivityOptions passivity;
  double gripper_cap = 0.0;  ///< largest torque on the operator's fingers; 0: the gripper has no motor [N m]
};

/// Input of the stage at every tick. A single axis uses the first component of each vector.
struct Input {
  DampedWrench commanded;  ///< wanted wrench on the hand, in L
  double t = 0.0;          ///< time of the tick [s]
  Handle handle;           ///< measured state of the handle
  Sample tool;             ///< stamp of the tool's state
  bool engaged = true;     ///< following and not clutched; otherwise the wrench ramps to zero
  double stiffness = 0.0;  ///< stiffness felt by the hand along the wanted force [N/m]
  double credit = 0.0;     ///< energy of potentials that were switched on in this tick, at the hand's port [J]
  double dt = 0.0;         ///< time since the last tick; 0: one period [s]
  double power = 0.0;      ///< of the motion of surfaces and other instruments on the tool, at the hand's port [W]
  /// Energy that the springs behind `commanded` store now, at the hand's port; infinity: unknown [J].
  double potential = std::numeric_limits<double>::infinity();
  /// The same at the present authority of the fixtures: `commanded` is its gradient [J].
  double present_potential = std::numeric_limits<double>::infinity();
};

/// Lag of a ramp of force in each element [s].
struct Lag {
  double coupling = 0.0;   ///< of the virtual coupling; negative: its damper leads
  double low_pass = 0.0;   ///< of the low-pass
  double passivity = 0.0;  ///< withheld force divided by the rate cap
  double caps = 0.0;       ///< input minus output of the limiter, divided by the rate cap
};

/// Output of the stage, on the hand in L.
struct Output {
  Wrench F_H_L;          ///< rendered wrench, including the damping
  DampedWrench on_hand;  ///< the same wrench; its damping is reduced as much as the force
  Wrench F_capped;       ///< output of the limiter, input of the passivity controller
  /// Withheld by each element: its input minus its output.
  Wrench F_coupling, F_low_pass, F_cut, F_passivity;
  Lag lag;
  unsigned status = 0;  ///< bits of Status
};

/// The stage. For any input its output is finite, below its cap and grows no faster than its rate cap, because only the
/// passivity controller follows the limiter, which reduces the wrench. A wrench that is not finite does not enter the
/// filters and resets them.
class Stability {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  Stability(const Options& options, double dt);

  /// One tick: passes the wanted wrench through the chain.
  Output step(const Input& in) noexcept;
  /// To be called after every step with the wrench that the drives render, including the damping.
  void rendered(const Wrench& F_H_L) noexcept;
  /// True if a state stamped `stamp` is too old to be trusted at the time `now` [s].
  [[nodiscard]] bool stale(double now, double stamp) const noexcept { return limiter_.stale(now, stamp); }
  [[nodiscard]] const PassivityController& passivity() const noexcept { return passivity_; }

 private:
  double dt_;
  Pose X_LH_;  ///< handle at the last tick
  bool started_ = false;
  Coupling coupling_;
  LowPass low_pass_;
  Limiter limiter_;
  PassivityController passivity_;
};

}  // namespace palpate::stability
