#include "palpate/torque/torque.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace palpate::torque {
namespace {

constexpr Eigen::Index kPositioning = 3;  // joints that place the wrist centre (section 2.3)
constexpr Eigen::Index kPlatform = 3;     // joint 4, counted from zero
constexpr Eigen::Index kMtmJoints = 7;

// The dVRK's platform controller (mtsIntuitiveResearchKitMTM, effort mode): it keeps the gimbal open.
constexpr double kPlatformReach = 0.05 * std::numbers::pi;  // [rad]
constexpr double kPlatformP = 1.0;                          // [N m/rad]
constexpr double kPlatformD = 0.1;                          // [N m s/rad]
constexpr double kPlatformMax = 0.4;                        // [N m]

/// J^T F, or with the first three joints only: the 3x3 Jacobian of the wrist centre and no wrist moments.
void force_torque(Mode mode, const Jacobian& J, const Wrench& F, JointVector& tau) noexcept {
  if (mode == Mode::paper) {
    tau.setZero(J.cols());
    const Eigen::Index m = std::min(kPositioning, J.cols());
    tau.head(m).noalias() = J.topLeftCorner(3, m).transpose() * F.f;
    return;
  }
  tau.noalias() = J.topRows<3>().transpose() * F.f + J.bottomRows<3>().transpose() * F.t;
}

double platform(double gain, const JointVector& q, const JointVector& v) noexcept {
  const double error = std::clamp(q[5] * std::cos(q[4]), -kPlatformReach, kPlatformReach);
  return std::clamp(gain * (kPlatformP * error - kPlatformD * v[kPlatform]), -kPlatformMax, kPlatformMax);
}

/// The largest share of tau_force that fits beside the torques that hold the arm up.
double share_that_fits(const JointVector& tau_force, const JointVector& tau_hold, const JointVector& limit) noexcept {
  double share = 1.0;
  for (Eigen::Index k = 0; k < limit.size(); ++k) {
    const double room = limit[k] - std::copysign(1.0, tau_force[k]) * tau_hold[k];
    const double wanted = std::abs(tau_force[k]);
    if (wanted > room) share = std::min(share, std::max(room, 0.0) / wanted);
  }
  return share;
}

}  // namespace

Torque::Torque(Options options, JointVector tau_max) : options_(options), tau_max_(std::move(tau_max)) {
  if (!(tau_max_.array() > 0.0).all()) {
    throw std::invalid_argument("every drive limit tau_max must be above zero; give the arm's URDF effort limits");
  }
  if (!(options_.platform_gain >= 0.0 && options_.platform_gain <= 1.0)) {
    throw std::invalid_argument("platform_gain must lie in 0..1; got " + std::to_string(options_.platform_gain));
  }
}

bool Torque::step(arm::Arm& model, const JointVector& q, const JointVector& v, const Wrench& F_H_L,
                  LeaderCommand& out) noexcept {
  const Eigen::Index n = tau_max_.size();
  const bool full = options_.mode == Mode::full;
  force_torque(options_.mode, model.jacobian(), F_H_L, out.tau_force);
  out.tau_gravity = options_.gravity_gain * model.holding(q);
  out.tau_platform.setZero(n);
  if (full && n == kMtmJoints) out.tau_platform[kPlatform] = platform(options_.platform_gain, q, v);
  if (!full && n > kPositioning) out.tau_gravity.tail(n - kPositioning).setZero();

  // Holding comes first: the arm must not fall because a force is asked for, nor for the platform's sake.
  const JointVector wanted = out.tau_gravity + out.tau_platform;
  const JointVector held = wanted.cwiseMax(-tau_max_).cwiseMin(tau_max_);
  out.tau_gravity = out.tau_gravity.cwiseMax(-tau_max_).cwiseMin(tau_max_).eval();
  out.tau_platform = held - out.tau_gravity;
  // One factor for all joints: the force gets smaller, its direction stays.
  const double share = share_that_fits(out.tau_force, held, tau_max_);
  out.tau_force *= share;
  out.F_H_L = {share * F_H_L.f, (full ? share : 0.0) * F_H_L.t};
  return share < 1.0 || held != wanted;
}

}  // namespace palpate::torque
