// A histogram of durations with bins 0.4 % wide: percentiles over days take a fixed memory and a constant time per
// entry.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

namespace palpate::loop {

/// One thread may add while any number of threads read.
class Histogram {
 public:
  /// Adds a duration; a negative one counts as zero.
  void add(std::int64_t nanoseconds) noexcept {
    const auto value = static_cast<std::uint64_t>(nanoseconds < 0 ? 0 : nanoseconds);
    bump(bins_[bin(value)]);
    bump(count_);
    if (value > max_.load(std::memory_order_relaxed)) {
      max_.store(value, std::memory_order_relaxed);
    }
  }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
  /// Longest duration [us].
  [[nodiscard]] double max_us() const noexcept {
    return 1e-3 * static_cast<double>(max_.load(std::memory_order_relaxed));
  }
  /// Value below which the fraction p (0..1) of all durations lies [us].
  [[nodiscard]] double percentile_us(double p) const noexcept {
    const double wanted = p * static_cast<double>(count());
    double seen = 0.0;
    for (std::size_t i = 0; i < kBins; ++i) {
      seen += static_cast<double>(bins_[i].load(std::memory_order_relaxed));
      if (seen >= wanted && seen > 0.0) {
        return 1e-3 * middle(i);
      }
    }
    return 0.0;
  }

 private:
  static constexpr int kBits = 8;  // 2^8 bins per octave
  static constexpr std::size_t kBins = static_cast<std::size_t>(64 - kBits) << kBits;

  static std::size_t bin(std::uint64_t value) noexcept {
    const int shift = value >> kBits == 0 ? 0 : static_cast<int>(std::bit_width(value >> kBits)) - 1;
    return (static_cast<std::size_t>(shift) << kBits) + (value >> shift);
  }
  static double middle(std::size_t i) noexcept {
    const std::size_t octave = i >> kBits;
    if (octave <= 1) {
      return static_cast<double>(i);
    }
    const std::size_t shift = octave - 1;
    const std::size_t mantissa = (i & ((1u << kBits) - 1)) + (1u << kBits);
    return (static_cast<double>(mantissa) + 0.5) * static_cast<double>(std::uint64_t{1} << shift);
  }
  static void bump(std::atomic<std::uint64_t>& n) noexcept {
    n.store(n.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  std::array<std::atomic<std::uint64_t>, kBins> bins_{};
  std::atomic<std::uint64_t> count_{0}, max_{0};
};

}  // namespace palpate::loop
