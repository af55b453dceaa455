// How old the newest packet is: percentiles for the jitter buffer, and the moment at which an outage is certain.
#pragma once

#include <array>
#include <cstddef>

namespace palpate::network {

/// Ages of the newest packet, for others to read; percentiles are the upper edge of their bin [s].
struct Ages {
  double age = 0.0, p50 = 0.0, p99 = 0.0, p999 = 0.0;
  int outages = 0;  ///< so far
};

/// The age of the newest packet at each tick covers delay, jitter, loss and reordering in one number. Its percentiles
/// come from a histogram that halves its counts every kForget ticks. A tick enters it kWait ticks later, and those
/// before and during an outage do not: otherwise the percentile would rise with the age.
///
/// An outage begins when the age exceeds limit(), and ends when the age is below it for kBack. If packets keep coming
/// for kSteady, only later than before, the delay itself has changed, and the histograms start anew.
///
/// A burst of losses looks like an outage until a packet comes. The limit is therefore p99.9 + kAlarm, or a later age
/// where bursts would otherwise raise more than one false alarm an hour. Their tail is measured: every arrival ends an
/// excursion of the age, the largest kTail excursions of the last kRemember lie above u by m in the mean, and an
/// exponential tail with this mean has one excursion an hour above
///
///   u + m (1 + 1/sqrt(kTail)) ln(excursions above u per hour).
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
  /// Age from which an outage is told [s].
  [[nodiscard]] double limit() const noexcept;
  /// Number of outages so far.
  [[nodiscard]] int outages() const noexcept { return outages_; }
  [[nodiscard]] Ages ages() const noexcept { return {age_, p50_, p99_, p999_, outages_}; }

 private:
  static constexpr std::size_t kBins = 4096;
  static constexpr double kBin = 1e-3;        ///< [s]
  static constexpr int kForget = 16384;       ///< [ticks]
  static constexpr std::size_t kWait = 128;   ///< [ticks]
  static constexpr int kRefresh = 32;         ///< [ticks] between two computations of the percentiles
  static constexpr double kAlarm = 0.045;     ///< [s]
  static constexpr double kBack = 0.05;       ///< [s]
  static constexpr int kFirst = 200;          ///< [ticks] before which only kPatience counts
  static constexpr double kPatience = 1.0;    ///< [s]
  static constexpr double kSteady = 0.5;      ///< [s]
  static constexpr double kTail = 40.0;       ///< excursions that make the tail
  static constexpr double kRemember = 300.0;  ///< [s] time after which the counts of excursions are halved
  static constexpr double kShort = 0.3;       ///< [s] shorter outages were bursts
  static constexpr double kBefore = 5.0;      ///< [s] of observation before which the tail does not count
  using Histogram = std::array<float, kBins>;
  void add(Histogram& to, double age) noexcept;
  void refresh() noexcept;
  void fit_tail() noexcept;
  void start_anew() noexcept;
  void watch(double limit, double dt) noexcept;
  void count(double age) noexcept;
  [[nodiscard]] static std::size_t bin_of(double age) noexcept;

  Histogram count_{}, peaks_{};                 ///< ages of all ticks; largest ages of all excursions
  std::size_t top_ = 0;                         ///< beyond the last bin of both that has counts
  double observed_ = 0.0, since_halved_ = 0.0;  ///< time in which the excursions were counted, and since a halving [s]
  double once_an_hour_ = 0.0;                   ///< age that an excursion exceeds once an hour [s]
  double total_ = 0.0, age_ = 0.0, oldest_ = 0.0, p50_ = 0.0, p99_ = 0.0, p999_ = 0.0, back_ = 0.0;
  double lasting_ = 0.0, since_ = 0.0,
         age_then_ = 0.0;                ///< time since a mark during an outage, and the age at the mark [s]
  std::array<double, kWait> waiting_{};  ///< ages that are not yet counted, as a ring [s]
  std::size_t first_ = 0, waits_ = 0;
  int ticks_ = 0, outages_ = 0;
  bool outage_ = false;
};

}  // namespace palpate::network
