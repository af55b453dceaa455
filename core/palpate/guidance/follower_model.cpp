#include "palpate/guidance/follower_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/types/servo.hpp"

namespace palpate::guidance {
namespace {

constexpr double kHorizon = 5.0;      // [1 / w] prediction horizon, after which the servo has settled
constexpr double kMaxLead = 3e-3;     // [m] largest lead of the goal over the tool
constexpr double kResetError = 5e-3;  // [m] prediction error beyond which the model restarts at the measured position
// Observer gains: fractions of the difference between measured and predicted position that correct the position and,
// per period, the velocity. They are small because the encoders are fine and the servo is known.
constexpr double kPlace = 0.5, kSpeed = 0.05;

}  // namespace

FollowerModel::FollowerModel(const ServoOptions& options, double dt) : options_(options), dt_(dt) {
  if (follows_at_once()) return;
  const double w = 2.0 * std::numbers::pi * options.bandwidth;
  step_ = servo_transition(w, options.damping_ratio, dt);
  const double last = std::max(kHorizon / w, 8.0 * dt), ratio = std::pow(last / dt, 1.0 / (kTimes - 1));
  double t = dt;
  for (StepResponse& response : response_) {
    const Eigen::Matrix2d phi = servo_transition(w, options.damping_ratio, t);
    response = {t, phi(0, 0), phi(0, 1)};
    t *= ratio;
  }
}

void FollowerModel::observe(const Vec3& p_WT) noexcept {
  if (!known_ || (p_WT - p_).norm() > kResetError) {
    p_ = goal_ = p_WT;
    v_.setZero();
    known_ = true;
    return;
  }
  const Vec3 off = p_WT - p_;
  p_ += kPlace * off;
  v_ += kSpeed / dt_ * off;
}

void FollowerModel::command(const Vec3& p_goal) noexcept {
  goal_ = p_goal;
  const Vec3 e = p_ - goal_;
  p_ = goal_ + step_(0, 0) * e + step_(0, 1) * v_;
  v_ = step_(1, 0) * e + step_(1, 1) * v_;
}

double FollowerModel::required_lead(double gap, double speed, double drift) const noexcept {
  double least = -1e3;
  for (const StepResponse& response : response_) {
    const double left = 1.0 - response.f;
    // Without speed and drift, the goal of a tool that has crossed the border has to lie at the border, not beyond it.
    const double from = gap >= 0.0 ? gap : left * gap;
    least = std::max(least, -(from + response.g * speed + drift * response.t) / left);
  }
  return std::min(least, kMaxLead + std::max(-gap, 0.0));
}

}  // namespace palpate::guidance
