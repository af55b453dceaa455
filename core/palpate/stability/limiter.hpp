// The limiter: for any input its output is finite, below its cap, and grows no faster than its rate cap. It also falls
// no faster, except as far as the hand's motion along a spring explains. Only the passivity controller and the drives'
// limits (stage `torque`) reduce the wrench further, in the same direction and without a ramp. rendered() reports such
// a loss, so that the wrench returns by a ramp.
#pragma once

#include <limits>

#include "palpate/stability/saturation.hpp"
#include "palpate/types/motion.hpp"
#include "palpate/types/spatial.hpp"
#include "palpate/types/status.hpp"

namespace palpate::stability {

/// Caps and watchdog.
struct Caps {
  double force_cap = 3.0;         ///< largest force on the hand [N]
  double rate_cap = 50.0;         ///< largest rate of change of the force [N/s]; also the ramp to zero
  double moment_cap = 0.05;       ///< largest moment on the hand [N m]; 0: forces only
  double moment_rate_cap = 0.85;  ///< largest rate of change of the moment [N m/s]; also the ramp to zero
  double stale_after = 0.03;      ///< age beyond which a state is not trusted [s]
};

/// Input of the limiter at every tick.
struct LimiterInput {
  Wrench F_H_L;             ///< wanted wrench on the hand
  double t = 0.0;           ///< time of the tick [s]
  Sample leader, follower;  ///< stamps of the states from which the wrench was computed
  bool engaged = true;      ///< following and not clutched; otherwise the wrench ramps to zero
  double explained = 0.0;   ///< fall of the force in this tick that the hand's motion explains: K |dx| [N]
  double dt = 0.0;          ///< time since the last tick; 0: one period [s]
  /// Energy that the springs behind the wrench store; infinity: unknown [J].
  double potential = std::numeric_limits<double>::infinity();
  double work = 0.0;            ///< of the hand against the last rendered wrench since the last tick [J]
  double work_of_motion = 0.0;  ///< of moving surfaces, with the wanted wrench, since the last tick [J]
};

/// Output of the limiter.
struct Limited {
  Wrench F_H_L;         ///< rendered wrench on the hand
  Wrench F_cut;         ///< wanted minus rendered wrench; a wanted wrench that is not finite counts as zero
  unsigned status = 0;  ///< bits of Status
};

/// With F_k-1 the last force and dt the period:
///
///   goal = trusted ? cap(s F_commanded, force_cap) : 0         s as in saturation.hpp, for the moment as well
///   F    = trusted ? cap(F_k-1, max(|goal|, |F_k-1| - explained)) : F_k-1        cap() shortens without turning
///   F_k  = F + cap(goal - F, rate_cap dt)
///
/// Goal and F_k-1 lie in the ball of radius force_cap, so F_k lies in it as well. A force that fell slower than its
/// spring would push a hand that moves away with energy that the spring never stored. Moments have caps of their own.
class Limiter {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  Limiter(const Caps& caps, double dt);

  /// One tick: limits the wanted wrench.
  Limited step(const LimiterInput& in) noexcept;
  /// The last rendered wrench.
  [[nodiscard]] const Wrench& now() const noexcept { return F_; }
  /// Sets the wrench that the drives rendered, which their limits may have reduced; the next step starts from it.
  void rendered(const Wrench& F_H_L) noexcept { F_ = F_H_L; }
  /// True if a state stamped `stamp` differs from the time `now` by more than stale_after, into the past or the future.
  [[nodiscard]] bool stale(double now, double stamp) const noexcept;
  [[nodiscard]] const Caps& caps() const noexcept { return caps_; }

 private:
  Caps caps_;
  double dt_;
  Wrench F_;
  Saturation saturation_;
};

}  // namespace palpate::stability
