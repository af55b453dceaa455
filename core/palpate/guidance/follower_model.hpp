// How the tool follows its goal: what a hard fixture has to know to keep the tool, not only its goal, out of a region.
//
//   p'' = w^2 (p_goal - p) - 2 zeta w p'         the joints' servo, seen at the tip
//
// With the goal held from now on, the tool is t later at p + (1 - f(t)) (goal - p) + g(t) p'. So for a border that it
// is `gap` away from along n, and that comes nearer by `drift`, the goal has to lie at least
//
//   n . (goal - p) >= max_t -(gap + g(t) n . p' + drift t) / (1 - f(t))
//
// ahead: linear in the goal, exact for a plane, and on the safe side for everything that bulges towards the tool.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

struct ServoOptions {
  double bandwidth = -1.0;     ///< natural frequency of the follower's joints behind their goals [Hz]; 0: at once;
                               ///< below zero: as of the follower where it is simulated, elsewhere at once
  double damping_ratio = 1.0;  ///< [-]
};

class FollowerModel {
 public:
  /// dt: period of the goals [s]. Throws std::invalid_argument naming an option that cannot be.
  FollowerModel(const ServoOptions& options, double dt);

  [[nodiscard]] bool follows_at_once() const noexcept { return options_.bandwidth <= 0.0; }
  /// The tool is measured at p_WT: corrects what is known of its velocity.
  void observe(const Vec3& p_WT) noexcept;
  /// It is sent to p_goal from now on.
  void command(const Vec3& p_goal) noexcept;
  [[nodiscard]] const Vec3& p() const noexcept { return p_; }
  [[nodiscard]] const Vec3& v() const noexcept { return v_; }
  /// The least n . (goal - p) that keeps the tool out, see above. gap [m], speed = n . p', drift [m/s].
  [[nodiscard]] double need(double gap, double speed, double drift) const noexcept;

 private:
  static constexpr std::size_t kTimes = 32;
  struct Later {
    double t, f, g;
  };

  ServoOptions options_;
  double dt_;
  std::array<Later, kTimes> later_{};
  Eigen::Matrix2d step_ = Eigen::Matrix2d::Identity();  ///< of (p - goal, p') over dt
  bool known_ = false;
  Vec3 p_ = Vec3::Zero(), v_ = Vec3::Zero(), goal_ = Vec3::Zero();
};

}  // namespace palpate::guidance
