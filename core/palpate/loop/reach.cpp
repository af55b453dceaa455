#include "palpate/loop/reach.hpp"

#include "palpate/types/so3.hpp"

namespace palpate::loop {
namespace {

/// Position error that counts as much as one radian [m]. It is a compromise: beyond the end of a shaft the wrist turns
/// little, and beyond a limit of the wrist the tip moves little.
constexpr double kLength = 0.03;
constexpr double kNoWorse = 1.0 + 1e-9;  // factor on an error that was not reduced

/// Square of the error of the tip at q.
double error2(arm::Arm& arm, const Pose& goal, const JointVector& q) noexcept {
  arm.update(q, JointVector::Zero(q.size()));
  const double far2 = (goal.p - arm.tip().p).squaredNorm() / (kLength * kLength);
  return arm.orients() ? far2 + rotation_vector(goal.R * arm.tip().R.transpose()).squaredNorm() : far2;
}

}  // namespace

bool Reach::step(arm::Arm& arm, const Pose& X_BT_goal, const Mat3& R_WB, const JointVector& q_step,
                 JointVector& q) noexcept {
  JointVector wanted = q;
  reached_ = arm.ik(X_BT_goal, wanted).converged && wanted.allFinite();
  if (!reached_) {
    arm::IkOptions nearest;
    nearest.length = kLength;
    wanted = q;
    arm.ik(X_BT_goal, wanted, nearest);
    if (!(wanted.allFinite() && error2(arm, X_BT_goal, wanted) <= kNoWorse * error2(arm, X_BT_goal, q))) {
      J_WT_.setZero();
      return false;
    }
    Mat6 R = Mat6::Zero();
    R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = R_WB;
    J_WT_ = R * arm.nearest_derivative(X_BT_goal, wanted, kLength) * R.transpose();
  }
  q += (wanted - q).cwiseMax(-q_step).cwiseMin(q_step).eval();
  return reached_;
}

}  // namespace palpate::loop
