// Executes a planned motion of the follower in the cycle: joint goals along a path that is known to be free, at a pace
// that other threads command.
#pragma once

#include <cstdint>

#include "palpate/loop/pace.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// Joint positions over time, interpolated by cubic Hermite polynomials.
struct PlannedMotion {
  std::uint64_t number = 0;  ///< set by Front; 0: no motion
  double dt = 0.0;           ///< time between two rows [s]
  Eigen::MatrixXd q, v;      ///< (n, K) positions [rad, m] and velocities [rad/s, m/s]
  JointVector levers;        ///< motion of the tip per motion of each joint (n,) [m/rad, 1]

  [[nodiscard]] double duration() const noexcept { return dt * static_cast<double>(q.cols() - 1); }
  /// Positions (n,) at the time t [s], which is limited to the duration.
  void at(double t, JointVector& out) const noexcept;
};

/// Throws std::invalid_argument if the motion cannot be executed. Not to be called from the cycle.
void check(const PlannedMotion& motion);

/// What other threads command an execution: levels, not events, so that no message can be lost.
struct ExecutionOrder {
  std::uint64_t motion = 0;  ///< number of the motion that the order is about; others ignore it
  double pace = 1.0;         ///< speed along the motion: 0 rests, 1 is as planned [-]
  double until = 0.0;        ///< time along the motion up to which it is known to be free; the motion rests there [s]
  bool stop = false;         ///< come to rest for good
  double guard = 1.0;        ///< force of a contact above which the motion stops for good [N]
};

/// Throws std::invalid_argument naming a value that is not allowed.
void check(const ExecutionOrder& order);

/// What an execution does; the signal `execution`.
enum class ExecutionPhase : std::uint8_t {
  none,       ///< no motion was given
  moving,     ///< a motion waits, moves or pauses
  done,       ///< the tool is at the end of the motion
  stopped,    ///< stopped by request
  released,   ///< stopped because the session left the state `executing`: a pedal, a hold, a fault
  touched,    ///< stopped by a contact
  corrected,  ///< stopped by a hard fixture that does not allow the goal
  elsewhere,  ///< refused: the tool is not at the start of the motion
};

/// Moves the follower's goal along one motion at a time, at a Pace: the goal never jumps and rests within kStopTime
/// after a stop, on the path.
class Execution {
 public:
  /// Time in which the goal of a motion at full pace comes to rest; the servos of the arm follow after it, in 35 ms to
  /// below 1 mm/s [s].
  static constexpr double kStopTime = 0.012;
  /// Largest distance of the goal from the start of a motion, as motion of the tip [m], and the time in which it
  /// vanishes after the start [s].
  static constexpr double kNear = 1e-3, kBlend = 0.2;
  /// Time for which a motion waits for the state `executing`; later it never begins [s].
  static constexpr double kPatience = 0.1;
  /// Difference up to which two times along a motion are the same [s]. The sender of an order and the cycle compute the
  /// end of the motion by different floating-point expressions; a motion that is free up to either end is free whole.
  static constexpr double kSameTime = 1e-9;

  /// dt: period of the cycle [s].
  explicit Execution(double dt) : dt_(dt) {}

  /// One tick. executing: the session is in the state `executing`. q: present goal of the joints (n,) [rad, m], which
  /// is moved. Returns true if the motion determines the goal in this tick.
  bool step(const PlannedMotion& motion, const ExecutionOrder& order, bool executing, JointVector& q) noexcept;
  /// Stops for good; the first reason is kept.
  void stop(ExecutionPhase reason) noexcept {
    if (phase_ == ExecutionPhase::moving) phase_ = reason;
  }
  /// True while a motion waits, moves or pauses.
  [[nodiscard]] bool wanted() const noexcept { return phase_ == ExecutionPhase::moving; }
  /// True while the goal is not at rest.
  [[nodiscard]] bool moves() const noexcept { return pace_.value() > 0.0; }
  [[nodiscard]] ExecutionPhase phase() const noexcept { return phase_; }
  [[nodiscard]] std::uint64_t motion() const noexcept { return number_; }
  [[nodiscard]] double time() const noexcept { return time_; }  ///< time along the motion [s]

 private:
  void take(const PlannedMotion& motion) noexcept;
  void wait(const PlannedMotion& motion, const JointVector& q, bool executing) noexcept;
  [[nodiscard]] double wanted_pace(const ExecutionOrder& order, double end) const noexcept;

  double dt_;
  std::uint64_t number_ = 0;
  ExecutionPhase phase_ = ExecutionPhase::none;
  bool begun_ = false;
  Pace pace_{kStopTime};
  double time_ = 0.0;
  double waited_ = 0.0;  ///< time since the motion was taken, until it begins [s]
  double blend_ = 0.0;   ///< time since the begin, in which the goal moves onto the path [s]
  JointVector offset_;   ///< of the goal from the start of the motion, when it began [rad, m]
};

}  // namespace palpate::loop
