// Runs the stage `guidance` along a given motion, for tests: the tool follows its goal without lag, above an elastic
// plane.
#pragma once

#include "palpate/guidance/guidance.hpp"

namespace palpate::guidance {

/// A plane that pushes like a spring along its normal.
struct ElasticPlane {
  Vec3 normal = Vec3::UnitZ();  ///< unit vector in W
  double stiffness = 0.0;       ///< [N/m]

  /// Force on a tool tip at p_WT, in W [N]. height: of the plane along its normal [m].
  [[nodiscard]] Vec3 force(const Vec3& p_WT, double height) const noexcept;
};

/// Conditions that are constant along a motion.
struct GuidanceRunOptions {
  ElasticPlane plane;
  double F_hand = -1.0;          ///< operator's force [N]; negative: not measured
  double pedal = 1.0;            ///< guidance pedal, 0-1
  bool renders_damping = false;  ///< the device renders damping by itself
};

/// Steps the stage with a tool that follows its goal without lag.
class GuidanceRun {
 public:
  /// The stage must outlive the run. X_WT: pose of the tool before the first tick.
  GuidanceRun(Guidance& stage, const GuidanceRunOptions& options, const Pose& X_WT);

  /// One tick at time t [s]; the tool is at the corrected goal of the previous tick and touches nothing.
  const Output& step(double t, const Pose& X_WT_goal, const Twist& V_WT) noexcept;
  /// The same; the tool touches the plane at `height` [m].
  const Output& step(double t, const Pose& X_WT_goal, const Twist& V_WT, double height) noexcept;

 private:
  Guidance& stage_;
  ElasticPlane plane_;
  Input in_;
};

}  // namespace palpate::guidance
