// A simulated axis of a haptic device: a mass with friction, held by a hand and pressed into a virtual wall that is
// sampled, quantised, filtered, delayed and capped. Certificates are checked against it.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "palpate/verify/swing.hpp"

namespace palpate::verify {

/// Options of the axis. x > 0 is inside the wall.
struct AxisOptions {
  double mass = 0.3;     ///< mass of the device [kg]
  double damping = 0.5;  ///< viscous friction [N s/m]
  double coulomb = 0.0;  ///< dry friction [N]

  double rate = 1000.0;          ///< rate of the haptic cycle [Hz]
  double delay = 0.0;            ///< delay from the measurement to the force; any number of periods [s]
  double jitter = 0.0;           ///< additional delay of each command, uniform in 0..jitter; the order is kept [s]
  double quantum = 0.0;          ///< resolution of the measured position; 0: ideal [m]
  double velocity_cutoff = 0.0;  ///< cutoff of the low-pass of the differenced position; 0: no filter [Hz]

  double K = 400.0;                                            ///< stiffness of the wall [N/m]
  double B = 0.0;                                              ///< damping of the wall [N s/m]
  bool bilateral = false;                                      ///< a spring that also pulls, instead of a wall
  double force_max = std::numeric_limits<double>::infinity();  ///< cap of the force [N]
  double rate_max = std::numeric_limits<double>::infinity();   ///< cap of the force's rate of change [N/s]

  double hand_mass = 0.0;       ///< mass of the hand, which moves with the device [kg]
  double hand_damping = 0.0;    ///< damping to the hand's intended position [N s/m]
  double hand_stiffness = 0.0;  ///< stiffness to the hand's intended position [N/m]
  std::uint64_t seed = 0;       ///< of the jitter
};

/// Initial state and excitation of a run.
struct AxisMotion {
  /// Duration [s]. Without a value the run covers the hand's path and then at least four periods of the slowest mode;
  /// it is doubled up to five times, until the motion rests or keeps its amplitude over twelve windows.
  std::optional<double> duration;
  double x0 = 0.0;           ///< initial position [m]
  double v0 = 0.0;           ///< initial velocity [m/s]
  double push = 0.0;         ///< constant force in addition to the hand's spring [N]
  std::vector<double> path;  ///< intended position of the hand at each cycle, linear in between; empty: 0 [m]
};

inline constexpr double kAxisQuanta = 8.0;   ///< amplitude that resolution alone may sustain [quanta]
inline constexpr double kAxisUnfelt = 1e-6;  ///< amplitude that counts as rest [m]

/// Period of the slowest undamped mode [s]: of all masses on the hand's spring alone if the axis can leave the wall,
/// otherwise on both springs; 0 without any spring. A delay can make the oscillation slower; the judge then uses the
/// slowest period that it observes.
[[nodiscard]] double slowest_period(const AxisOptions& options) noexcept;

/// Result of a run. Amplitudes are half of peak to peak. judge_swing() judges the motion from the time at which the
/// hand's path is constant, with slowest_period() and a floor of max(8 quanta, 1 um).
struct AxisResult {
  bool diverged = false;    ///< the axis left |x| < 1 m
  bool oscillates = false;  ///< the axis left |x| < 1 m, or its swing lasts
  Swing swing = Swing::undecided;
  double growth = 0.0;       ///< relative growth rate of the amplitude, from its trend; 0 if at rest or undecided [1/s]
  double duration = 0.0;     ///< duration of the run [s]
  double amplitude = 0.0;    ///< amplitude in the last quarter [m]
  double frequency = 0.0;    ///< in the last quarter [Hz]
  double peak = 0.0;         ///< largest x [m]
  double rest = 0.0;         ///< mean x of the last quarter [m]
  double overshoot = 0.0;    ///< (peak - rest) / rest; 0 unless the axis rests inside the wall [-]
  double settling = 0.0;     ///< time after which |x - rest| stays below max(2 % of |rest|, 8 quanta, 1 um) [s]
  double energy_port = 0.0;  ///< energy that the wall took from the hand, by true positions: - sum of F dx [J]
  double energy_min = 0.0;   ///< smallest energy_port of the run; negative: the wall had generated energy [J]
};

/// State at a cycle; forces act on the device along x.
struct AxisRow {
  double t, x, v, F, energy;  ///< [s], [m], [m/s], commanded force [N], energy_port [J]
};

/// A stage between the force of the wall and the commanded force.
class AxisStage {
 public:
  virtual ~AxisStage() = default;
  /// Returns the force to command [N]. F: wanted force along x [N]. x: measured position [m]. dt: period of the cycle
  /// [s].
  virtual double step(double F, double x, double dt) noexcept = 0;
};

/// Simulates the motion
///
///   (m + m_h) x'' = u + push - b x' + k_h (x_h - x) + b_h (x_h' - x') - F_c sign x',     |friction| <= F_c at rest
///
/// exactly, with the force u of the last command that has arrived, the friction b and F_c (`coulomb`) of the device,
/// the hand's m_h, b_h, k_h and its intended position x_h. u is constant between two arrivals of a command, so x has a
/// closed form up to the next arrival, cycle or reversal, and the times of sticking and breakaway are roots. At cycle k
///
///   x_k = quantum round(x / quantum),   v_k = v_k-1 + low_pass_coefficient(velocity_cutoff, T) ((x_k - x_k-1) / T -
///   v_k-1) F_k = -max(K x_k + B v_k, 0) if x_k > 0, else 0        (bilateral: always -(K x_k + B v_k))
///
/// F_k is capped, passed to the stage if there is one, and applied from  k T + delay + jitter  on.
class Axis {
 public:
  /// Throws std::invalid_argument naming the option, its value and the remedy.
  explicit Axis(const AxisOptions& options);
  /// Runs from the initial state; the same options and motion give the same result. stage: not owned, may be null.
  /// rows: receives a row for every cycle; may be null.
  AxisResult run(const AxisMotion& motion, AxisStage* stage = nullptr, std::vector<AxisRow>* rows = nullptr);
  [[nodiscard]] const AxisOptions& options() const noexcept { return options_; }

 private:
  AxisOptions options_;
};

}  // namespace palpate::verify
