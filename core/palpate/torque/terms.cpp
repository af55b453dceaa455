#include "palpate/torque/terms.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::torque {
namespace {

constexpr double kPlatformReach = 0.05 * std::numbers::pi;  // [rad] largest position error that is corrected
constexpr double kPlatformP = 1.0;                          // [N m/rad] proportional gain
constexpr double kPlatformD = 0.1;                          // [N m s/rad] derivative gain
constexpr double kPlatformMax = 0.4;                        // [N m] largest torque

}  // namespace

JointVector friction(const FrictionOptions& options, const JointVector& v) noexcept {
  JointVector tau = JointVector::Zero(v.size());
  if (options.gain == 0.0 || options.coulomb.size() != v.size()) return tau;
  for (Eigen::Index k = 0; k < v.size(); ++k) {
    const double speed = std::abs(v[k]);
    const double share = (speed - options.dead_band) / (options.full_speed - options.dead_band);
    const double r = std::clamp(share, 0.0, 1.0);
    tau[k] = options.gain * r * (std::copysign(options.coulomb[k], v[k]) + options.viscous[k] * v[k]);
  }
  return tau;
}

JointVector limits(const LimitOptions& options, const JointVector& q, const JointVector& q_min,
                   const JointVector& q_max, const JointVector& tau_max) noexcept {
  JointVector tau = JointVector::Zero(q.size());
  if (options.gain == 0.0) return tau;
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const double margin = options.margin * (q_max[k] - q_min[k]);
    const double low = std::clamp((q_min[k] + margin - q[k]) / margin, 0.0, 1.0);
    const double high = std::clamp((q[k] - q_max[k] + margin) / margin, 0.0, 1.0);
    tau[k] = options.gain * tau_max[k] * (low - high);
  }
  return tau;
}

double platform(double gain, const JointVector& q, const JointVector& v) noexcept {
  const double error = std::clamp(q[5] * std::cos(q[4]), -kPlatformReach, kPlatformReach);
  return std::clamp(gain * (kPlatformP * error - kPlatformD * v[3]), -kPlatformMax, kPlatformMax);
}

}  // namespace palpate::torque
