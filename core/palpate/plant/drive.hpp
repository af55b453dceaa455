// The leader's drives. They hold the last command, delay its response_torque() term (force, friction, soft stops),
// saturate, lag, and let response_torque() fade when commands stop.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "palpate/types/arms.hpp"

namespace palpate::plant {

struct LeaderDriveOptions {
  double delay = 0.0;          ///< delay of response_torque() from command to torque [s]
  double jitter = 0.0;         ///< additional delay of each command, uniform in 0..jitter; the order is kept [s]
  double lag = 0.0;            ///< time constant of the current loops, for the whole torque [s]
  double hold_timeout = 0.03;  ///< age of the last command after which response_torque() fades [s]
  JointVector tau_max;         ///< saturation (n,) [N m]
  std::uint64_t seed = 0;      ///< seed of the jitter
};

class Drive {
 public:
  explicit Drive(LeaderDriveOptions options);
  void reset() noexcept;
  /// Takes the newest command. A command that is not finite is refused, as by a real drive; the last one remains.
  void command(const LeaderCommand& command) noexcept;
  /// Joint torques of this servo period (n,), zero beyond the last joint: delayed response_torque() + support_torque(),
  /// within tau_max, after the lag [N m].
  const JointVector& step(double dt) noexcept;

 private:
  struct Sent {
    double due = 0.0;  ///< time at which the command acts [s]
    JointVector tau;   ///< response_torque()
  };
  void arrive() noexcept;

  LeaderDriveOptions options_;
  Lanes tau_max_;
  std::mt19937_64 random_;
  double t_ = 0.0, t_sent_ = -1.0;
  Sent acting_;
  JointVector tau_support_, tau_;
  bool settled_ = false;    ///< true if tau_ is the result of the present commands with fade_
  double fade_ = 1.0;       ///< share of the response torque in tau_
  std::vector<Sent> line_;  ///< commands that are still delayed: a ring of size_ from head_
  std::size_t head_ = 0, size_ = 0;
};

}  // namespace palpate::plant
