#include "palpate/network/local_plane.hpp"

#include <algorithm>
#include <memory>

#include "palpate/scene/primitives.hpp"
#include "palpate/types/so3.hpp"

namespace palpate::network {
namespace {

constexpr double kTurnLag = 0.02;  // [s] time constant of a turn that no limit holds back
constexpr double kAway = 0.02;     // [m] below the tool: a plane that is not believed
constexpr double kClear = 1e-4;    // [m] below the tool's sphere: a plane that appears
constexpr double kUnknown = 1e3;   // [m] distance of a plane that nobody has touched

}  // namespace

scene::Object LocalPlane::object() {
  scene::Object out;
  out.name = "unknown surface";
  out.surface = std::make_shared<scene::Plane>();
  out.X_WO.p.z() = -kUnknown;
  out.material.K.setConstant(EstimatorOptions{}.K);
  return out;
}

void LocalPlane::aim(const Vec3& p, const Vec3& F, double radius, const Vec3& now, double dt, scene::Object& object,
                     ModelEstimate& goal) noexcept {
  if (goal.normal.isZero(0.0)) {
    goal.shift = now;
    return;
  }
  Pose& X = object.X_WO;
  if (!placed_) {
    X.R = rotation_between(Vec3::UnitZ(), goal.normal);
    X.p = p - (radius + kClear) * goal.normal;
    placed_ = true;
  }
  const Vec3 n = X.R.col(2);
  const Vec3 turn = rotation_vector(rotation_between(n, goal.normal));
  const double angle = turn.norm(), force = F.norm(), most = kTurnShare * force_rate_ * dt;
  double step = angle * dt / (kTurnLag + dt);
  if (force * step > most) step = most / force;
  if (angle > 0.0) {
    const Mat3 R = rotation_by(turn * (step / angle));
    X.p = p + R * (X.p - p);
    X.R = Eigen::Quaterniond(R * X.R).normalized().toRotationMatrix();
  }
  const Vec3 normal = X.R.col(2), away = p - goal.shift;
  const double along = goal.normal.dot(away);
  const bool believed = (away - along * goal.normal).norm() < kPlaneReach;
  const double gap = believed ? along : std::max(along, radius + kAway);  // of the tool's centre
  goal.shift = now + (normal.dot(p - X.p) - gap) * normal;
}

}  // namespace palpate::network
