// Watches one stream of stamped messages from a device on a network: are they new, fresh and plausible?
#pragma once

#include <cstdint>

#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// A time on two clocks: the monotonic clock, which never jumps, and the system clock, which stamps refer to.
struct ClockTime {
  double t = 0.0;     ///< monotonic clock [s]
  double wall = 0.0;  ///< system clock, since 1970 [s]
};

/// Limits beyond which a stream is not trusted.
struct WatchOptions {
  double stale_after = 0.03;  ///< largest silence, age of a stamp and jump of a clock [s]
  double v_max = 3.0;         ///< largest speed of a hand or an instrument [m/s]
  double w_max = 40.0;        ///< largest angular speed [rad/s]
  double p_slack = 0.005;     ///< tolerance of the speed check, for jitter of the stamps [m]
  double R_slack = 0.2;       ///< the same for rotations [rad]
};

/// The newest reason of a fault, with the numbers that people need to find it.
struct Cause {
  std::uint64_t bit = 0;  ///< bit of Status; 0: none
  double value = 0.0;     ///< value that was refused, in SI units; docs/ros2-real-arm.md lists it for each bit
  double other = 0.0;     ///< second value, such as the limit
};

/// Faults since the last question.
struct Faults {
  std::uint64_t bits = 0;  ///< bits of Status
  Cause cause;             ///< of the newest one
};

/// Estimates the offset of a sender's clock: the smallest age of a stamp within the last second. What varies above it
/// is jitter. A constant delay cannot be told from an offset.
class ClockOffset {
 public:
  /// age: of a stamp at its arrival [s]; t: time of arrival [s].
  void add(double age, double t) noexcept;
  /// Time by which the sender's clock is ahead of this machine's; negative: behind, or a delay [s].
  [[nodiscard]] double value() const noexcept { return known_ ? -(least_ < before_ ? least_ : before_) : 0.0; }

 private:
  bool known_ = false;
  double begin_ = 0.0, least_ = 0.0, before_ = 0.0;  ///< begin of the present window, smallest ages of both windows [s]
};

/// A stream is good while it is neither silent nor late. Messages that arrive twice or out of order are ignored, which
/// is not a fault. These are faults: a stamp of zero (which means invalid), a stamp far from this machine's clock, a
/// clock that jumps, a number that is not finite, a quaternion that is not a rotation, a position beyond the reach of
/// any arm, a motion that is too fast, and poses that jump to and fro. Each has a bit of its own.
class Watch {
 public:
  explicit Watch(const WatchOptions& options = {}) : options_(options) {}

  /// True if a message stamped `stamp` [s] that arrives now is to be used. Faults add to faults().
  bool stamp(double stamp, ClockTime now) noexcept;
  /// Checks the pose of a message whose stamp() was accepted, and writes it to X. Returns false if the numbers are no
  /// pose; a motion that is too fast only adds to faults(). Position [m] and quaternion x y z w as received.
  bool pose(const Vec3& p, const Eigen::Vector4d& quat, Pose& X) noexcept;
  /// Adds a bit of Status to the faults, with its values, and returns false: the message is not used.
  bool refuse(std::uint64_t bit, double value = 0.0, double other = 0.0) noexcept;

  /// Returns the faults since the last call and clears them.
  Faults take_faults() noexcept;
  /// True once a message has been accepted.
  [[nodiscard]] bool received() const noexcept { return received_; }
  /// True if nothing new arrives. Messages that are refused have their own bit, and are no silence.
  [[nodiscard]] bool stale(ClockTime now) const noexcept;
  /// Time since the last new message [s]; infinity before the first.
  [[nodiscard]] double silence(ClockTime now) const noexcept;
  /// Time between the last two stamps [s].
  [[nodiscard]] double interval() const noexcept { return interval_; }

  // Statistics for display.
  [[nodiscard]] double age() const noexcept { return age_; }  ///< age of the last stamp at its arrival [s]
  [[nodiscard]] double clock_offset() const noexcept { return offset_.value(); }  ///< of the sender's clock [s]
  [[nodiscard]] double period() const noexcept { return period_; }  ///< mean time between messages; 0: unknown [s]
  [[nodiscard]] std::uint64_t accepted() const noexcept { return accepted_; }  ///< number of accepted messages
  [[nodiscard]] std::uint64_t ignored() const noexcept { return ignored_; }    ///< number of repeated or late messages

 private:
  void check_motion(const Pose& next) noexcept;

  WatchOptions options_;
  bool received_ = false, placed_ = false, heard_ = false;
  double t_ = 0.0, stamp_ = 0.0, interval_ = 0.0, age_ = 0.0, period_ = 0.0;
  double heard_at_ = 0.0;  ///< arrival of the last message that was new or refused [s]
  Pose X_;
  Vec6 step_ = Vec6::Zero();  ///< last displacement that was more than noise; rotations as motion at a lever [m]
  double step_age_ = 0.0;     ///< time since then [s]
  double zigzag_ = 0.0;       ///< distance that was travelled to and fro, fading [m]
  Faults faults_;
  ClockOffset offset_;
  std::uint64_t accepted_ = 0, ignored_ = 0;
};

}  // namespace palpate::loop
