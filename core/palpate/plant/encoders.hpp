// Motor-side encoders: positions in whole counts; velocities from the time between edges, as the hardware measures, or
// from differences of counts; low-passed on request.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::plant {

struct EncoderOptions {
  JointMatrix coupling;          ///< A: q_joint = A q_motor
  JointVector step;              ///< motor-side (n,) [rad/count]; 0 = ideal
  double velocity_window = 0.0;  ///< 0: time between edges; else the difference of two positions so far apart [s]
  double velocity_cutoff = 0.0;  ///< of a first-order low-pass of the velocities; 0 = none [Hz]
};

class Encoders {
 public:
  explicit Encoders(const EncoderOptions& options);
  void reset(const JointVector& q) noexcept;
  /// The true joint positions one period later.
  void step(const JointVector& q, double dt) noexcept;
  [[nodiscard]] const JointVector& q() const noexcept { return q_; }  ///< joint side [rad]
  [[nodiscard]] const JointVector& v() const noexcept { return v_; }  ///< joint side [rad/s]

 private:
  /// One encoder. v = distance between the last two edges over the time between them; without an edge for longer
  /// than that, |v| <= step / (time since the last edge): it decays, it does not jump to zero.
  struct Track {
    double motor = 0.0, counts = 0.0, edge = 0.0, v_edges = 0.0;
    double since_edge = 0.0;  ///< [s]
    double step(double motor_now, double resolution, double dt) noexcept;
  };

  /// motor_ a window ago; until then, where it began.
  const JointVector& earlier(double dt) noexcept;

  EncoderOptions options_;
  JointMatrix A_inverse_;
  JointVector q_, v_, motor_, motor_v_;
  std::array<Track, kMaxJoints> track_;
  std::vector<JointVector> history_;  ///< motor_ of the last periods, a ring
  std::size_t newest_ = 0;
};

}  // namespace palpate::plant
