// Model of how the tool follows its goal. With it a hard fixture keeps the tool, not only the goal, out of a region.
//
//   p'' = w^2 (p_goal - p) - 2 zeta w p'         servo of the joints, seen at the tip
//
// While the goal is held, the tool is at p + (1 - f(t)) (goal - p) + g(t) p' after the time t. Let `gap` be the
// distance of the tool from a border along its normal n, and `drift` the rate of the gap due to the border's own
// motion. The tool stays outside if
//
//   n . (goal - p) >= max_t -(gap + g(t) n . p' + drift t) / (1 - f(t))
//
// This condition is linear in the goal, exact for a plane, and conservative for a region that is convex towards the
// tool.
#pragma once

#include <array>

#include "palpate/guidance/interface/options.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// Estimates the tool's velocity, and predicts its motion behind the goal.
class FollowerModel {
 public:
  /// options: valid ones (check()). dt: period of the goals [s].
  FollowerModel(const ServoOptions& options, double dt);

  /// True if the tool follows its goal without lag.
  [[nodiscard]] bool follows_at_once() const noexcept { return options_.bandwidth <= 0.0; }
  /// Corrects the estimated position and velocity by the measured position p_WT [m].
  void observe(const Vec3& p_WT) noexcept;
  /// Predicts the state one period ahead, with the goal p_goal [m].
  void command(const Vec3& p_goal) noexcept;
  /// Estimated position [m] and velocity [m/s] of the tool, in W.
  [[nodiscard]] const Vec3& p() const noexcept { return p_; }
  [[nodiscard]] const Vec3& v() const noexcept { return v_; }
  /// The smallest n . (goal - p) that keeps the tool outside [m], as above. gap [m], speed = n . p' [m/s], drift [m/s].
  [[nodiscard]] double required_lead(double gap, double speed, double drift) const noexcept;

 private:
  static constexpr std::size_t kTimes = 32;
  struct StepResponse {
    double t, f, g;  ///< f and g [s] as above, at the time t [s]
  };

  ServoOptions options_;
  double dt_;
  std::array<StepResponse, kTimes> response_{};
  Eigen::Matrix2d step_ = Eigen::Matrix2d::Identity();  ///< transition matrix of (p - goal, p') over one period dt
  bool known_ = false;
  Vec3 p_ = Vec3::Zero(), v_ = Vec3::Zero(), goal_ = Vec3::Zero();
};

}  // namespace palpate::guidance
