// Does a sampled motion keep swinging? The judge of every oscillation on one axis.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::verify {

enum class Swing : std::uint8_t {
  rests,      ///< the end of the record moves by no more than the floor
  decays,     ///< it still moves, with an amplitude that falls, or without turning back
  lasts,      ///< it swings with an amplitude that does not fall: a limit cycle, or growth
  undecided,  ///< it moves, but the record holds too few periods to tell
};
[[nodiscard]] const char* swing_name(Swing swing) noexcept;

struct SwingJudgement {
  Swing swing = Swing::undecided;
  double growth = 0.0;      ///< trend of the logarithm of the amplitude, relative; 0 where undecided [1/s]
  double change = 0.0;      ///< the same over all watched windows; -0.01: 1 % quieter [-]
  std::size_t windows = 0;  ///< watched; 0 where it rests or is undecided
  double period = 0.0;      ///< length of the windows' slowest period: the given one, or the slowest seen [s]
};

inline constexpr double kSwingTransient = 0.25;   ///< share of the record that is left to the transient [-]
inline constexpr std::size_t kSwingWindows = 12;  ///< windows of one slowest period or more
inline constexpr std::size_t kSwingFewest = 4;    ///< fewer windows decide nothing
inline constexpr double kSwingErrors = 3.0;       ///< a trend is one beyond so many of its standard errors
inline constexpr double kSwingLost = 0.002;       ///< smallest loss of amplitude over the windows that is a decay [-]

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
