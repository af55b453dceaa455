// Judges whether a sampled motion keeps oscillating. Every judgement of an oscillation on one axis uses it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::verify {

enum class Swing : std::uint8_t {
  rests,      ///< the amplitude at the end of the record is at most the floor
  decays,     ///< the motion goes on with a falling amplitude, or without turning back
  lasts,      ///< the amplitude does not fall: a limit cycle, or growth
  undecided,  ///< the motion goes on, but the record holds too few periods
};
[[nodiscard]] const char* swing_name(Swing swing) noexcept;

/// Result of judge_swing().
struct SwingJudgement {
  Swing swing = Swing::undecided;
  double growth = 0.0;      ///< slope of the logarithm of the amplitude; 0 if undecided [1/s]
  double change = 0.0;      ///< change of that logarithm over all windows; -0.01: 1 % smaller [-]
  std::size_t windows = 0;  ///< number of windows; 0 if at rest or undecided
  double period = 0.0;      ///< slowest period: the given one, or the longest observed [s]
};

inline constexpr double kSwingTransient = 0.25;   ///< fraction of the record that is left to the transient [-]
inline constexpr std::size_t kSwingWindows = 12;  ///< largest number of windows
inline constexpr std::size_t kSwingFewest = 4;    ///< smallest number of windows for a decision
inline constexpr double kSwingErrors = 3.0;       ///< standard errors of the slope beyond which a trend is significant
inline constexpr double kSwingLost =
    0.002;  ///< smallest relative loss of amplitude over all windows that counts as a decay [-]

/// The record's last three quarters are divided into up to twelve equal windows, each at least one period of the
/// slowest mode long: `period`, or the longest time between two upward crossings of the mean if that is longer. The
/// amplitude A_i of a window is half the range of x in it, so that an oscillation of any mean, shape and frequency
/// above that of the slowest mode has a constant A_i exactly if it neither grows nor decays.
///
/// It rests if the last quarter of the watched part, or its last period if that is longer, has an amplitude of no more
/// than `floor`. Otherwise it decays if log A_i falls along its regression line by more than three standard errors of
/// the slope, by 0.2 % over all windows and from their middle third to their last, or if fewer than half of the windows
/// hold a motion that turns back. Otherwise it lasts.
///
/// x: positions from the time on at which nothing outside moves any more [m]; dt: between them [s]; period: of the
/// slowest mode [s]; floor: amplitude that counts as rest [m].
[[nodiscard]] SwingJudgement judge_swing(std::span<const double> x, double dt, double period, double floor) noexcept;

}  // namespace palpate::verify
