// Synchronised point-to-point motion of several joints, which start at any position and velocity and come to rest
// together. Each joint moves in three phases of constant acceleration (+-a, 0, +-a):
//   q(t): v0 -> v_c at +-a,  v_c,  v_c -> 0 at +-a,   |v_c| <= v_max
// The slowest joint moves as fast as its limits allow; the cruising speeds v_c of the others give the same duration.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::dvrk {

/// A synchronised point-to-point motion of several joints.
class Trajectory {
 public:
  /// Starts a motion from q, v to rest at goal. v_max, a_max: limits of each joint, above zero. All have one length.
  void start(const JointVector& q, const JointVector& v, const JointVector& goal, const JointVector& v_max,
             const JointVector& a_max) noexcept;
  void stop() noexcept { active_ = false; }
  /// Advances by dt [s] and updates q(), v() and done().
  void step(double dt) noexcept;

  [[nodiscard]] bool active() const noexcept { return active_; }        ///< started, and not yet done or stopped
  [[nodiscard]] bool done() const noexcept { return done_; }            ///< at rest at the goal
  [[nodiscard]] double duration() const noexcept { return duration_; }  ///< duration of the whole motion [s]
  [[nodiscard]] const JointVector& q() const noexcept { return q_; }
  [[nodiscard]] const JointVector& v() const noexcept { return v_; }
  [[nodiscard]] const JointVector& goal() const noexcept { return goal_; }

 private:
  struct Phases {
    double v0 = 0.0, v_c = 0.0, a = 1.0;
    double t_first = 0.0, t_last = 0.0;  ///< durations of the first and last phase [s]
  };

  std::array<Phases, kMaxJoints> phases_;
  JointVector q0_, goal_, q_, v_;
  double t_ = 0.0, duration_ = 0.0;
  bool active_ = false, done_ = false;
};

}  // namespace palpate::dvrk
