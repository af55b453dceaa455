// Encoders on the motors: positions in whole counts, and velocities as the hardware estimates them.
#pragma once

#include <cstddef>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::plant {

struct EncoderOptions {
  JointMatrix coupling;  ///< A: q_joint = A q_motor
  JointVector step;      ///< resolution on the motor side (n,) [rad/count]; 0 = ideal
  double velocity_window =
      0.0;  ///< 0: time between edges; otherwise the difference of two positions this far apart [s]
  double velocity_cutoff = 0.0;  ///< cut-off of a first-order low-pass of the velocities; 0 = no filter [Hz]
};

/// Positions and velocities of all joints, as measured on the motors.
///
/// The velocity between edges is the distance between the last two edges over the time between them. Without an edge
/// for longer than that, |v| <= step / (time since the last edge): the velocity decays instead of jumping to zero.
class Encoders {
 public:
  explicit Encoders(const EncoderOptions& options);
  /// At rest at q.
  void reset(const JointVector& q) noexcept;
  /// Counts the motion to the true joint positions q (zero beyond the last joint) within one period dt.
  void step(const Lanes& q, double dt) noexcept;
  /// Fills q() and v() with the measurement of the last period.
  void read() noexcept;
  [[nodiscard]] const JointVector& q() const noexcept { return q_; }  ///< joint side [rad]
  [[nodiscard]] const JointVector& v() const noexcept { return v_; }  ///< joint side [rad/s]

 private:
  /// State of all encoders.
  struct alignas(64) Tracks {
    Lanes motor{};         ///< true position [rad]
    Lanes motor_before{};  ///< the same one period ago [rad]
    Lanes counts{};        ///< whole counts of the true position
    Lanes edge{};          ///< position of the last edge [rad]
    Lanes v_edges{};       ///< velocity between the last two edges [rad/s]
    Lanes since_edge{};    ///< time since the last edge [s]
  };
  static void pass_edges(const Lanes (&inverse)[kLanes], const Lanes& step, const Lanes& q, double dt,
                         Tracks& track) noexcept;
  /// Positions and velocities from the state after this period.
  void estimate(double dt) noexcept;
  /// Motor positions one window ago, or those of the reset if that is later.
  const JointVector& earlier(double dt) noexcept;

  EncoderOptions options_;
  Lanes coupling_[kLanes]{}, inverse_[kLanes]{};  ///< columns of A and of its inverse
  Lanes step_{};                                  ///< resolution; 1 for ideal encoders, whose result is replaced
  bool ideal_ = false;                            ///< true if any encoder is ideal
  bool every_period_ = false;  ///< true if velocities depend on the positions of all periods, not on the edges alone
  Tracks track_;
  JointVector q_, v_, motor_, motor_v_;
  std::vector<JointVector> history_;  ///< motor_ of the last periods, a ring
  std::size_t newest_ = 0;
};

}  // namespace palpate::plant
