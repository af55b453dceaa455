// Measures the time of each stage of a cycle, for benchmarks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "palpate/loop/histogram.hpp"
#include "palpate/loop/realtime.hpp"

namespace palpate::loop {

/// Stages of a cycle, and their names.
enum class Stage : std::uint8_t { kinematics, mapping, guidance, contact, force, stability, torque, record };
inline constexpr std::array kStageNames = {"kinematics", "mapping",   "guidance", "contact",
                                           "force",      "stability", "torque",   "record"};

/// The cycle writes; other threads may read meanwhile.
class StageClock {
 public:
  /// Begins a cycle.
  void start() noexcept {
    spent_.fill(0);
    last_ = now_ns();
  }
  /// Adds the time since start() or the last mark() to this stage.
  void mark(Stage stage) noexcept {
    const std::int64_t now = now_ns();
    spent_[static_cast<std::size_t>(stage)] += now - last_;
    last_ = now;
  }
  /// Ends a cycle and adds the times of its stages to the histograms.
  void finish() noexcept {
    for (std::size_t i = 0; i < spent_.size(); ++i) times_[i].add(spent_[i]);
  }
  /// Times of a stage, given by its index in Stage.
  [[nodiscard]] const Histogram& time(std::size_t stage) const noexcept { return times_[stage]; }

 private:
  std::int64_t last_ = 0;
  std::array<std::int64_t, kStageNames.size()> spent_{};
  std::array<Histogram, kStageNames.size()> times_;
};

}  // namespace palpate::loop
