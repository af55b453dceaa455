// How old the newest packet is: percentiles for the jitter buffer, and the moment at which an outage is certain.
#pragma once

#include <array>
#include <cstddef>

namespace palpate::network {

/// The age of the newest packet at each tick covers delay, jitter, loss and reordering in one number. Its percentiles
/// come from a histogram that halves its counts every kForget ticks. A tick enters it kWait ticks later, and those
/// before and during an outage do not: otherwise the percentile would rise with the age.
///
/// An outage begins when the age exceeds its p99.9 by kAlarm, and ends when the age is below this limit for kBack. If
/// packets keep coming for kSteady, only later than before, the delay itself has changed, and the histogram starts
/// anew.
class Arrivals {
 public:
  /// One tick: age of the newest packet [s]; dt: time since the last tick [s].
  void step(double age, double dt) noexcept;
  [[nodiscard]] bool outage() const noexcept { return outage_; }
  /// Time since the outage was told; 0 without one [s].
  [[nodiscard]] double lasting() const noexcept { return outage_ ? lasting_ : 0.0; }
  /// Age of the newest packet [s].
  [[nodiscard]] double age() const noexcept { return age_; }
  /// Percentiles of the age, upper edge of their bin [s].
  [[nodiscard]] double p50() const noexcept { return p50_; }
  [[nodiscard]] double p99() const noexcept { return p99_; }
  [[nodiscard]] double p999() const noexcept { return p999_; }
  /// Number of outages so far.
  [[nodiscard]] int outages() const noexcept { return outages_; }

 private:
  static constexpr std::size_t kBins = 4096;
  static constexpr double kBin = 1e-3;       ///< [s]
  static constexpr int kForget = 16384;      ///< [ticks]
  static constexpr std::size_t kWait = 128;  ///< [ticks]
  static constexpr int kRefresh = 32;        ///< [ticks] between two computations of the percentiles
  static constexpr double kAlarm = 0.045;    ///< [s]
  static constexpr double kBack = 0.05;      ///< [s]
  static constexpr int kFirst = 200;         ///< [ticks] before which only kPatience counts
  static constexpr double kPatience = 1.0;   ///< [s]
  static constexpr double kSteady = 0.5;     ///< [s]
  void refresh() noexcept;
  void watch(double limit, double dt) noexcept;
  void count(double age) noexcept;

  std::array<float, kBins> count_{};
  double total_ = 0.0, age_ = 0.0, p50_ = 0.0, p99_ = 0.0, p999_ = 0.0, back_ = 0.0;
  double lasting_ = 0.0, since_ = 0.0,
         age_then_ = 0.0;                ///< time since a mark during an outage, and the age at the mark [s]
  std::array<double, kWait> waiting_{};  ///< ages that are not yet counted, as a ring [s]
  std::size_t first_ = 0, waits_ = 0;
  int ticks_ = 0, outages_ = 0;
  bool outage_ = false;
};

}  // namespace palpate::network
