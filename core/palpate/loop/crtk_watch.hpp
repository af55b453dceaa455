// Watches one stream of stamped messages from a device on a network: is what it says new, fresh and possible?
#pragma once

#include <cstdint>

#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// A moment on two clocks: our monotonic one, which never jumps, and the system's, in which stamps are told.
struct Moment {
  double t = 0.0;     ///< monotonic [s]
  double wall = 0.0;  ///< since 1970 [s]
};

struct WatchOptions {
  double stale_after = 0.03;  ///< silence, age of a stamp and jump of a clock beyond which nothing is believed [s]
  double v_max = 3.0;         ///< no hand and no instrument moves faster [m/s]
  double w_max = 40.0;        ///< or turns faster [rad/s]
  double p_slack = 0.005;     ///< on top of it, for jitter of stamps [m]
  double R_slack = 0.2;       ///< [rad]
};

/// A stream is good while it is neither silent nor late. Messages that come twice or out of order are left out, which
/// is no fault. Everything else that cannot be is one: a stamp of zero (the sender says: not valid), a stamp far from
/// our clock, clocks that jump, numbers that are not finite, a rotation that is none, a motion that is too fast.
class Watch {
 public:
  explicit Watch(const WatchOptions& options = {}) : options_(options) {}

  /// Is a message stamped `stamp` [s] that arrives now to be taken? Faults add to faults().
  bool stamp(double stamp, Moment now) noexcept;
  /// A pose after a stamp that was taken: could it have moved so far? Numbers as they came, quaternion x y z w.
  bool pose(const Vec3& p, const Eigen::Vector4d& quat, Pose& X) noexcept;
  /// Adds bits of Status to the faults, and does not take the message.
  bool refuse(unsigned bits) noexcept;

  /// Bits of Status since the last call.
  unsigned faults() noexcept;
  [[nodiscard]] bool heard() const noexcept { return heard_; }
  /// Silent, or late, now?
  [[nodiscard]] bool stale(Moment now) const noexcept;
  /// Between the last two stamps [s].
  [[nodiscard]] double interval() const noexcept { return interval_; }

  // For people.
  [[nodiscard]] double age() const noexcept { return age_; }        ///< of the last stamp when it came [s]
  [[nodiscard]] double period() const noexcept { return period_; }  ///< mean time between messages; 0: unknown [s]
  [[nodiscard]] std::uint64_t taken() const noexcept { return taken_; }
  [[nodiscard]] std::uint64_t left_out() const noexcept { return left_out_; }  ///< twice, or out of order

 private:
  WatchOptions options_;
  bool heard_ = false, placed_ = false;
  double t_ = 0.0, stamp_ = 0.0, interval_ = 0.0, age_ = 0.0, period_ = 0.0;
  Pose X_;
  unsigned faults_ = 0;
  std::uint64_t taken_ = 0, left_out_ = 0;
};

}  // namespace palpate::loop
