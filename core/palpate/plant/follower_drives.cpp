#include "palpate/plant/follower_drives.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

namespace palpate::plant {
namespace {

constexpr double kShortest = 1e-4, kLongest = 0.02;  // [s] shortest and longest time from one goal to the next

DriveOptions checked(DriveOptions o, Eigen::Index n) {
  const auto check = [n](const char* name, JointVector& x) {
    if (x.size() == 0) x = JointVector::Zero(n);
    if (x.size() == n && (x.array() >= 0.0).all()) return;
    throw std::invalid_argument("follower drives' " + std::string(name) + " needs " + std::to_string(n) +
                                " entries, one per joint, none below zero; got " + std::to_string(x.size()) +
                                " (Arm.follower_options() fills them)");
  };
  check("coulomb", o.coulomb);
  check("viscous", o.viscous);
  check("rotor_inertia", o.rotor_inertia);
  return o;
}

}  // namespace

FollowerDrives::FollowerDrives(arm::Arm arm, DriveOptions options, double natural_frequency, double damping_ratio,
                               const JointVector& encoder_step)
    : arm_(std::move(arm)),
      options_(checked(std::move(options), arm_.n())),
      w_(2.0 * std::numbers::pi * natural_frequency),
      zeta_(damping_ratio),
      encoders_({JointMatrix::Identity(arm_.n(), arm_.n()), encoder_step}) {
  if (!(natural_frequency > 0.0)) {
    throw std::invalid_argument("a follower with drives needs a bandwidth above 0 Hz: ideal joints have no torque");
  }
  if (!(arm_.tau_max().array() > 0.0).all()) {
    throw std::invalid_argument("a follower with drives needs their limits: give its joints effort limits in the URDF");
  }
  reset(JointVector::Zero(arm_.n()));
}

void FollowerDrives::reset(const JointVector& q) noexcept {
  q_ = q;
  goal_ = q;
  left_ = 0.0;
  v_ = goal_v_ = JointVector::Zero(q.size());
  tau_ = arm_.holding(q);
  friction_.reset(q.size());
  encoders_.reset(q);
  arm_.dynamics(q_, v_);
}

void FollowerDrives::aim(const JointVector& q_goal, double period) noexcept {
  left_ = std::clamp(period, kShortest, kLongest);
  goal_v_ = (q_goal - goal_) / left_;
}

// In plain loops over the joints: Eigen's expressions of many terms take seconds to compile.
void FollowerDrives::step(double dt, const Wrench& F_T_B) noexcept {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const double way = std::min(dt, left_);
  left_ -= way;
  const arm::Dynamics& d = arm_.state();  // at (q_, v_), the end of the last step
  const Eigen::Index n = q_.size();
  const JointVector elastic = arm_.elastic(q_);
  const JointVector &q_min = arm_.q_min(), &q_max = arm_.q_max(), &tau_max = arm_.tau_max();
  alignas(64) Lanes A_rows[kLanes]{}, b{}, lo{}, hi{}, q_true;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) A_rows[i][j] = d.M(i, j);
    A_rows[i][i] += options_.rotor_inertia[i];
    for (Eigen::Index j = 0; j < n; ++j) b[i] += A_rows[i][j] * v_[j];
  }
  for (Eigen::Index k = 0; k < n; ++k) {
    goal_[k] += way * goal_v_[k];
    // Weight and Coriolis forces are compensated by feed-forward.
    const double acceleration = w_ * w_ * (goal_[k] - q_[k]) - 2.0 * zeta_ * w_ * v_[k];
    tau_[k] = std::clamp(d.bias[k] + elastic[k] + A_rows[k][k] * acceleration, -tau_max[k], tau_max[k]);
    const auto J_k = d.J.col(k);
    b[k] += dt * (tau_[k] - d.bias[k] - elastic[k]);
    b[k] += dt * (J_k.head<3>().dot(F_T_B.f) + J_k.tail<3>().dot(F_T_B.t));
    A_rows[k][k] += dt * options_.viscous[k];
    const double impulse = dt * options_.coulomb[k];  // at an end stop the impulse of the stop has no bound
    hi[k] = q_[k] <= q_min[k] ? kInfinity : impulse;
    lo[k] = q_[k] >= q_max[k] ? -kInfinity : -impulse;
  }
  v_ = friction_.solve(A_rows, b, lo, hi);
  for (Eigen::Index k = 0; k < n; ++k) q_[k] = std::clamp(q_[k] + dt * v_[k], q_min[k], q_max[k]);
  pad(q_, q_true);
  encoders_.step(q_true, dt);
  encoders_.read();
  arm_.dynamics(q_, v_);
}

}  // namespace palpate::plant
