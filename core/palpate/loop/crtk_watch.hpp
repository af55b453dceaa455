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

/// A stream is good while it is neither silent nor late. Messages that arrive twice or out of order are ignored, which
/// is not a fault. These are faults: a stamp of zero (which means invalid), a stamp far from this machine's clock, a
/// clock that jumps, a number that is not finite, a quaternion that is not a rotation, a motion that is too fast.
class Watch {
 public:
  explicit Watch(const WatchOptions& options = {}) : options_(options) {}

  /// True if a message stamped `stamp` [s] that arrives now is to be used. Faults add to faults().
  bool stamp(double stamp, ClockTime now) noexcept;
  /// Checks the pose of a message whose stamp() was accepted, and writes it to X. Returns false if the numbers are no
  /// pose; a motion that is too fast only adds to faults(). Position [m] and quaternion x y z w as received.
  bool pose(const Vec3& p, const Eigen::Vector4d& quat, Pose& X) noexcept;
  /// Adds bits of Status to the faults and returns false: the message is not used.
  bool refuse(unsigned bits) noexcept;

  /// Returns the faults since the last call, as bits of Status, and clears them.
  unsigned take_faults() noexcept;
  /// True once a message has been accepted.
  [[nodiscard]] bool received() const noexcept { return received_; }
  /// True if the stream is silent or late.
  [[nodiscard]] bool stale(ClockTime now) const noexcept;
  /// Time between the last two stamps [s].
  [[nodiscard]] double interval() const noexcept { return interval_; }

  // Statistics for display.
  [[nodiscard]] double age() const noexcept { return age_; }        ///< age of the last stamp at its arrival [s]
  [[nodiscard]] double period() const noexcept { return period_; }  ///< mean time between messages; 0: unknown [s]
  [[nodiscard]] std::uint64_t accepted() const noexcept { return accepted_; }  ///< number of accepted messages
  [[nodiscard]] std::uint64_t ignored() const noexcept { return ignored_; }    ///< number of repeated or late messages

 private:
  WatchOptions options_;
  bool received_ = false, placed_ = false;
  double t_ = 0.0, stamp_ = 0.0, interval_ = 0.0, age_ = 0.0, period_ = 0.0;
  Pose X_;
  unsigned faults_ = 0;
  std::uint64_t accepted_ = 0, ignored_ = 0;
};

}  // namespace palpate::loop
