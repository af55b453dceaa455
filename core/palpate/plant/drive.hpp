// The leader's drives: they hold the last command, delay what acts (force, friction, soft stops), and let it fade when
// nobody commands.
#pragma once

#include <cstddef>
#include <vector>

#include "palpate/types/arms.hpp"

namespace palpate::plant {

class Drive {
 public:
  /// delay, hold_timeout [s]; tau_max (n,) [N m].
  Drive(double delay, double hold_timeout, JointVector tau_max);
  void reset() noexcept;
  /// The newest command; one that is not finite is refused, as a drive would, and the last one stays.
  void command(const LeaderCommand& command) noexcept;
  /// Joint torques of this servo period: delayed act() + hold(), within tau_max.
  const JointVector& step(double dt) noexcept;

 private:
  double delay_, hold_timeout_, age_ = 0.0;
  JointVector tau_max_, tau_force_, tau_hold_, tau_;
  std::vector<JointVector> line_;  ///< force terms of the last periods, a ring
  std::size_t head_ = 0;
};

}  // namespace palpate::plant
