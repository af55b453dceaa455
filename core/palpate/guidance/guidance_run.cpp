#include "palpate/guidance/guidance_run.hpp"

#include <algorithm>

namespace palpate::guidance {

Vec3 ElasticPlane::force(const Vec3& p_WT, double height) const noexcept {
  return stiffness * std::max(height - normal.dot(p_WT), 0.0) * normal;
}

GuidanceRun::GuidanceRun(Guidance& stage, const GuidanceRunOptions& options, const Pose& X_WT)
    : stage_(stage), plane_(options.plane) {
  in_.goal.engaged = true;
  in_.tool.X_WT = X_WT;
  in_.tool_force.stiffness = options.plane.stiffness;
  in_.handle.F_hand = options.F_hand;
  in_.handle.renders_damping = options.renders_damping;
  in_.pedal = options.pedal;
}

const Output& GuidanceRun::step(double t, const Pose& X_WT_goal, const Twist& V_WT) noexcept {
  in_.t = t;
  in_.goal.X_WT_goal = X_WT_goal;
  in_.goal.V_WT = V_WT;
  const Output& out = stage_.step(in_);
  in_.tool.X_WT = out.X_WT_goal;
  return out;
}

const Output& GuidanceRun::step(double t, const Pose& X_WT_goal, const Twist& V_WT, double height) noexcept {
  in_.tool_force.F_T_W.f = plane_.force(in_.tool.X_WT.p, height);
  return step(t, X_WT_goal, V_WT);
}

}  // namespace palpate::guidance
