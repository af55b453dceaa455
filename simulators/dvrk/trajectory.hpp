// Point-to-point motion of several joints that start together, wherever and however fast they are, and come to rest
// together: each by three phases of constant acceleration (+-a, 0, +-a) with a cruising speed v_c between them,
//   q(t): v0 -> v_c at +-a,  v_c,  v_c -> 0 at +-a,   |v_c| <= v_max,
// the slowest joint as fast as its limits let it, the others with the cruising speed that takes as long.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::dvrk {

class Trajectory {
 public:
  /// From q, v to rest at goal. v_max, a_max above zero, per joint; all of one length.
  void start(const JointVector& q, const JointVector& v, const JointVector& goal, const JointVector& v_max,
             const JointVector& a_max) noexcept;
  void stop() noexcept { active_ = false; }
  /// dt further on. Afterwards q(), v() hold; done() once it rests at its goal.
  void step(double dt) noexcept;

  [[nodiscard]] bool active() const noexcept { return active_; }  ///< started, and not yet done or stopped
  [[nodiscard]] bool done() const noexcept { return done_; }
  [[nodiscard]] double duration() const noexcept { return duration_; }  ///< of all of it [s]
  [[nodiscard]] const JointVector& q() const noexcept { return q_; }
  [[nodiscard]] const JointVector& v() const noexcept { return v_; }
  [[nodiscard]] const JointVector& goal() const noexcept { return goal_; }

 private:
  struct Phases {
    double v0 = 0.0, v_c = 0.0, a = 1.0;
    double t_first = 0.0, t_last = 0.0;  ///< of speeding up and of slowing down [s]
  };

  std::array<Phases, kMaxJoints> phases_;
  JointVector q0_, goal_, q_, v_;
  double t_ = 0.0, duration_ = 0.0;
  bool active_ = false, done_ = false;
};

}  // namespace palpate::dvrk
