// Stage `stability`: one element after the other, each a file of its own, the limiter last.
//
//   wanted -> virtual coupling -> low-pass -> passivity controller -> caps, rate limit, watchdog -> rendered
//
// Only the drives' limits (stage `torque`) may leave less of it, in the same direction: that loss is as sudden as the
// limit is, and rendered() tells it, so that the way back is a ramp again.
#pragma once

#include "palpate/stability/coupling.hpp"
#include "palpate/stability/limiter.hpp"
#include "palpate/stability/low_pass.hpp"
#include "palpate/stability/passivity.hpp"
#include "palpate/types/damped_wrench.hpp"
#include "palpate/types/motion.hpp"
#include "palpate/types/spatial.hpp"
#include "palpate/types/status.hpp"

namespace palpate::stability {

struct Options : Caps {
  CouplingOptions coupling;
  LowPassOptions low_pass;
  PassivityOptions passivity;
};

/// Input of the stage at every tick. A single axis uses the first component of each vector.
struct Input {
  DampedWrench wanted;     ///< on the hand, in L
  double t = 0.0;          ///< now [s]
  Handle handle;           ///< measured
  Sample tool;             ///< of the tool's state
  bool engaged = true;     ///< following and not clutched: only then the hand is given a wrench
  double stiffness = 0.0;  ///< felt by the hand, along the wanted force [N/m]
  double credit = 0.0;     ///< energy of potentials that were switched on in this tick, at the hand's port [J]
};

/// How much later a ramp of force comes out of each element [s].
struct Lag {
  double coupling = 0.0;   ///< below zero: its damper leads
  double low_pass = 0.0;   ///< of the filter
  double passivity = 0.0;  ///< at the rate cap, the time it would take to give what is withheld now
  double caps = 0.0;       ///< at the rate cap, the time it takes to what is asked now
};

/// Output of the stage.
struct Output {
  Wrench F_H_L;                                ///< rendered on the hand, the damping included
  DampedWrench on_hand;                        ///< the same wrench; its damping is reduced as much as the force
  Wrench F_capped;                             ///< what the limiter was asked for
  Wrench F_coupling, F_low_pass, F_passivity;  ///< what each element kept: its input minus its output
  Lag lag;
  unsigned status = 0;  ///< bits of Status
};

/// Whatever comes in, what goes out is finite, below its cap and changes no faster than its rate cap: the limiter has
/// the last word. A wrench that is not finite passes no filter: it stops there, and the filters start afresh.
class Stability {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an option that cannot be.
  Stability(const Options& options, double dt);

  Output step(const Input& in) noexcept;
  /// To be called after every step with the wrench that the drives really rendered, the damping included.
  void rendered(const Wrench& F_H_L) noexcept;
  [[nodiscard]] bool stale(double now, double stamp) const noexcept { return limiter_.stale(now, stamp); }
  [[nodiscard]] const PassivityController& passivity() const noexcept { return passivity_; }

 private:
  Coupling coupling_;
  LowPass low_pass_;
  PassivityController passivity_;
  Limiter limiter_;
};

}  // namespace palpate::stability
