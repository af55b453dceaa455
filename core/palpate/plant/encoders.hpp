// Motor-side encoders: positions in whole counts, velocities from the time between edges, as the hardware measures.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::plant {

class Encoders {
 public:
  /// coupling A: q_joint = A q_motor; step: motor-side [rad/count], 0 = ideal.
  Encoders(const JointMatrix& coupling, JointVector step);
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

  JointMatrix A_, A_inverse_;
  JointVector step_, q_, v_, motor_, motor_v_;
  std::array<Track, kMaxJoints> track_;
};

}  // namespace palpate::plant
