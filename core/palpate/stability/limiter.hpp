// The last word on the wrench. Whatever comes in, what goes out is finite, below its cap, and changes no faster than
// its rate cap. Only the drives' limits (stage `torque`) may leave less of it, in the same
// direction: that loss is as sudden as the limit is, and rendered() tells it, so that the way back is a ramp again.
#pragma once

#include "palpate/types/motion.hpp"
#include "palpate/types/spatial.hpp"
#include "palpate/types/status.hpp"

namespace palpate::stability {

/// Caps and watchdog.
struct Caps {
  double force_cap = 3.0;         ///< largest force on the hand [N]
  double rate_cap = 50.0;         ///< largest change of it [N/s]; also the ramp to zero
  double moment_cap = 0.05;       ///< largest moment on the hand [N m]; 0: forces only
  double moment_rate_cap = 0.85;  ///< largest change of it [N m/s]; also the ramp to zero
  double stale_after = 0.03;      ///< states older than this are not trusted [s]
};

/// Input of the limiter at every tick.
struct Wanted {
  Wrench F_H_L;             ///< wanted on the hand
  double t = 0.0;           ///< now [s]
  Sample leader, follower;  ///< of the states from which the wrench was computed
  bool engaged = true;      ///< following and not clutched: only then the hand is given a wrench
};

/// Output of the limiter.
struct Limited {
  Wrench F_H_L;         ///< rendered on the hand
  Wrench F_cut;         ///< wanted minus rendered; what was not finite counts as zero wanted
  unsigned status = 0;  ///< bits of Status
};

/// With F_k-1 the last force and dt the period:
///
///   goal = trusted ? cap(F_wanted, force_cap) : 0
///   F_k  = F_k-1 + cap(goal - F_k-1, rate_cap dt)         cap() shortens a vector, keeps its direction
///
/// Both ends of each step lie in the ball of radius force_cap, so F_k does. Moments alike, with caps of their own.
class Limiter {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an option that cannot be.
  Limiter(const Caps& caps, double dt);

  Limited step(const Wanted& in) noexcept;
  /// What step() would render of a trusted wrench: needed before the step.
  [[nodiscard]] Wrench next(const Wrench& F_H_L) const noexcept;
  /// The last wrench rendered.
  [[nodiscard]] const Wrench& now() const noexcept { return F_; }
  /// What was really rendered, when a drive limit left less of it: the next step starts from there.
  void rendered(const Wrench& F_H_L) noexcept { F_ = F_H_L; }
  /// Is a state stamped `stamp` too old at `now`? One from the future is as suspicious as one from the past.
  [[nodiscard]] bool stale(double now, double stamp) const noexcept;
  [[nodiscard]] const Caps& caps() const noexcept { return caps_; }

 private:
  Caps caps_;
  double dt_;
  Wrench F_;
};

}  // namespace palpate::stability
