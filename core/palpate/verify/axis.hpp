// One axis of a haptic device: a mass with friction, held by a hand, pressed into a virtual wall that is sampled,
// quantised, filtered, delayed and cut off. What a certificate is judged by.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "palpate/verify/swing.hpp"

namespace palpate::verify {

/// x > 0 is inside the wall. All in SI.
struct AxisOptions {
  double mass = 0.3;     ///< of the device [kg]
  double damping = 0.5;  ///< viscous [N s/m]
  double coulomb = 0.0;  ///< dry friction [N]

  double rate = 1000.0;          ///< of the haptic cycle [Hz]
  double delay = 0.0;            ///< from the measurement to the force; any number of periods [s]
  double jitter = 0.0;           ///< added to it anew in each cycle, uniform in 0..jitter; order is kept [s]
  double quantum = 0.0;          ///< of the measured position; 0 = ideal [m]
  double velocity_cutoff = 0.0;  ///< of the low pass after the difference of two positions; 0 = none [Hz]

  double K = 400.0;                                            ///< stiffness of the wall [N/m]
  double B = 0.0;                                              ///< its damping [N s/m]
  bool bilateral = false;                                      ///< a spring that pulls, too, in the place of a wall
  double force_max = std::numeric_limits<double>::infinity();  ///< the force is cut there [N]
  double rate_max = std::numeric_limits<double>::infinity();   ///< it changes no faster [N/s]

  double hand_mass = 0.0;       ///< moves with the device [kg]
  double hand_damping = 0.0;    ///< to where the hand wants to be [N s/m]
  double hand_stiffness = 0.0;  ///< the same [N/m]
  std::uint64_t seed = 0;       ///< of the jitter
};

/// What happens to it.
struct AxisMotion {
  /// [s]; none: the hand's path and, from the time on at which it rests, four periods of the slowest mode or more,
  /// doubled up to five times until the motion rests, or until twelve windows of it do not lose amplitude.
  std::optional<double> duration;
  double x0 = 0.0;           ///< at the start [m]
  double v0 = 0.0;           ///< [m/s]
  double push = 0.0;         ///< constant force beside the hand's spring [N]
  std::vector<double> path;  ///< where the hand wants to be at each cycle, straight between them; empty: 0 [m]
};

inline constexpr double kAxisQuanta = 8.0;   ///< amplitude that resolution alone may keep alive [quanta]
inline constexpr double kAxisUnfelt = 1e-6;  ///< amplitude that counts as rest [m]

/// Period of the slowest undamped mode [s]: of all masses on the hand's spring alone where the wall can be left, else
/// on both springs; 0 without any spring. Delay can make a swing slower: then the judge goes by the slowest that it
/// sees.
[[nodiscard]] double slowest_period(const AxisOptions& options) noexcept;

/// Amplitudes are half of peak to peak. Whether it swings is judged by `judge_swing` from the time on at which the
/// hand's path rests, with `slowest_period` and a floor of max(8 quanta, 1 um).
struct AxisResult {
  bool diverged = false;    ///< it left |x| < 1 m
  bool oscillates = false;  ///< it left |x| < 1 m, or its swing lasts
  Swing swing = Swing::undecided;
  double growth = 0.0;       ///< of the amplitude, relative, by its trend; 0 where it rests or is undecided [1/s]
  double duration = 0.0;     ///< of the run [s]
  double amplitude = 0.0;    ///< in the last quarter [m]
  double frequency = 0.0;    ///< in the last quarter [Hz]
  double peak = 0.0;         ///< deepest [m]
  double rest = 0.0;         ///< mean of the last quarter [m]
  double overshoot = 0.0;    ///< (peak - rest) / rest; 0 where it does not rest inside the wall [-]
  double settling = 0.0;     ///< from then on |x - rest| < 2 % of |rest| or the floor [s]
  double energy_port = 0.0;  ///< taken from the hand by the wall, true: - sum of F dx [J]
  double energy_min = 0.0;   ///< lowest that it was: below zero the wall had made energy [J]
};

/// At each cycle; forces are on the device along x.
struct AxisRow {
  double t, x, v, F, energy;  ///< [s], [m], [m/s], force commanded [N], energy_port [J]
};

/// What may stand between the force that the wall wants and the force that is commanded.
class AxisStage {
 public:
  virtual ~AxisStage() = default;
  /// F: wanted on the hand along x [N]; x: measured [m]; dt: of the cycle [s]. Answers the force to command [N].
  virtual double step(double F, double x, double dt) noexcept = 0;
};

/// The motion
///
///   (m + m_h) x'' = u + push - b x' + k_h (x_h - x) + b_h (x_h' - x') - f_c sign x',     |friction| <= f_c at rest
///
/// is followed exactly: u is constant between two arrivals of a command, so that x is a closed form up to the next
/// arrival, cycle or reversal, and where it sticks and breaks away are roots of it. At cycle k
///
///   x_k = quantum round(x / quantum),   v_k = v_k-1 + low_pass_share(f_c, T) ((x_k - x_k-1) / T - v_k-1)
///   F_k = -max(K x_k + B v_k, 0) if x_k > 0, else 0        (bilateral: always -(K x_k + B v_k))
///
/// cut off, handed to the stage if there is one, and applied from  k T + delay + jitter  on.
class Axis {
 public:
  /// Throws std::invalid_argument naming the option, its value and the mend.
  explicit Axis(const AxisOptions& options);
  /// Starts afresh: same options and motion, same result. stage: not owned. rows: every cycle is added to it.
  AxisResult run(const AxisMotion& motion, AxisStage* stage = nullptr, std::vector<AxisRow>* rows = nullptr);
  [[nodiscard]] const AxisOptions& options() const noexcept { return options_; }

 private:
  AxisOptions options_;
};

}  // namespace palpate::verify
