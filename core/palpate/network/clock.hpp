// The offset between the clocks of both ends, from the times of packets alone.
#pragma once

#include <array>
#include <cstddef>

namespace palpate::network {

/// Offset of the peer's clock by the times of an exchange, as NTP measures it: t1 sent here, t2 received there, t3 sent
/// there, t4 received here,
///
///   forward = t2 - t1,   backward = t4 - t3,   offset = (forward - backward) / 2,   |error| <= (forward + backward) /
///   2
///
/// with the smallest forward and backward of each of the last kBins intervals of kSpan. A line through the offsets of
/// the intervals gives the drift; an interval whose smallest round trip is longer than the best has less weight. The
/// error equals half of the difference of the smallest delays of both directions, which no exchange can see.
class ClockSync {
 public:
  /// One exchange; t1 and t4 on the own clock, t2 and t3 on the peer's [s].
  void add(double t1, double t2, double t3, double t4) noexcept;
  /// True once an exchange is known.
  [[nodiscard]] bool known() const noexcept { return size_ > 0; }
  /// Peer's clock minus own clock at the own time t [s].
  [[nodiscard]] double offset(double t) const noexcept { return offset_ + drift_ * (t - t0_); }
  /// Rate of the peer's clock relative to the own one, minus 1 [-].
  [[nodiscard]] double drift() const noexcept { return drift_; }
  /// Bound of the error of the offset by an unknown asymmetry: half of the smallest round trip [s].
  [[nodiscard]] double bound() const noexcept { return bound_; }

 private:
  static constexpr std::size_t kBins = 24;
  static constexpr double kSpan = 0.5;        ///< [s]
  static constexpr double kFirstDrift = 4.0;  ///< [s] observed time from which the drift is estimated
  struct Bin {
    double t = 0.0, forward = 0.0, backward = 0.0;
  };
  void fit() noexcept;

  std::array<Bin, kBins> bins_{};
  std::size_t head_ = 0, size_ = 0;
  double offset_ = 0.0, drift_ = 0.0, t0_ = 0.0, bound_ = 0.0;
};

}  // namespace palpate::network
