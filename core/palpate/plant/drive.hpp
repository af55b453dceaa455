// The leader's drives: they hold the last command, delay what acts (force, friction, soft stops), saturate, follow with
// a lag, and let the force fade when nobody commands.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "palpate/types/arms.hpp"

namespace palpate::plant {

struct LeaderDriveOptions {
  double delay = 0.0;          ///< from command to torque, of act() only [s]
  double jitter = 0.0;         ///< on top of it: uniform from 0 to this, of each command anew, order kept [s]
  double lag = 0.0;            ///< time constant of the current loops, of all torque [s]
  double hold_timeout = 0.03;  ///< without a fresh command act() fades [s]
  JointVector tau_max;         ///< saturation (n,) [N m]
  std::uint64_t seed = 0;      ///< of the jitter
};

class Drive {
 public:
  explicit Drive(LeaderDriveOptions options);
  void reset() noexcept;
  /// The newest command; one that is not finite is refused, as a drive would, and the last one stays.
  void command(const LeaderCommand& command) noexcept;
  /// Joint torques of this servo period (n,), zero beyond the last joint: delayed act() + hold(), within tau_max, after
  /// the lag [N m].
  const JointVector& step(double dt) noexcept;

 private:
  struct Sent {
    double due = 0.0;  ///< when it acts [s]
    JointVector tau;   ///< act()
  };
  void arrive() noexcept;

  LeaderDriveOptions options_;
  Lanes tau_max_;
  std::mt19937_64 random_;
  double t_ = 0.0, t_sent_ = -1.0;
  Sent acting_;
  JointVector tau_hold_, tau_;
  std::vector<Sent> line_;  ///< on their way, a ring of size_ from head_ on
  std::size_t head_ = 0, size_ = 0;
};

}  // namespace palpate::plant
