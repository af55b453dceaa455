#include "palpate/plant/follower.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "palpate/types/servo.hpp"

namespace palpate::plant {
namespace {

double round_to(double x, double step) noexcept { return step > 0.0 ? std::nearbyint(x / step) * step : x; }

void check(const FollowerOptions& o, Eigen::Index n) {
  if (o.v_max.size() != n || o.encoder_step.size() != n) {
    throw std::invalid_argument("follower v_max and encoder_step need " + std::to_string(n) +
                                " entries, one per joint; got " + std::to_string(o.v_max.size()) + " and " +
                                std::to_string(o.encoder_step.size()) + " (Arm.follower_options() fills them)");
  }
  if (!(o.v_max.array() > 0.0).all() || !(o.encoder_step.array() >= 0.0).all()) {
    throw std::invalid_argument("follower v_max must be above zero and encoder_step not below zero (0 = ideal)");
  }
  if (!(o.bandwidth >= 0.0) || !(o.damping_ratio > 0.0) || !(o.jaw_v_max > 0.0)) {
    throw std::invalid_argument(
        "follower bandwidth must be >= 0 (0 = ideal), damping_ratio and jaw_v_max above zero; got " +
        std::to_string(o.bandwidth) + " Hz, " + std::to_string(o.damping_ratio) + ", " + std::to_string(o.jaw_v_max) +
        " rad/s");
  }
}

}  // namespace

Follower::Follower(const arm::Arm& model, FollowerOptions options)
    : options_(std::move(options)), q_min_(model.q_min()), q_max_(model.q_max()) {
  check(options_, q_min_.size());
  if (options_.driven) {
    drives_.emplace(model, options_.drives, options_.bandwidth, options_.damping_ratio, options_.encoder_step);
  }
  reset(JointVector::Zero(q_min_.size()), 0.0);
}

void Follower::reset(const JointVector& q, double jaw) noexcept {
  q_ = q.cwiseMax(q_min_).cwiseMin(q_max_);
  v_ = JointVector::Zero(q_.size());
  if (drives_) drives_->reset(q_);
  command_ = {q_, jaw, true};
  jaw_ = jaw;
  t_ = t_command_ = 0.0;
  measure();
}

void Follower::command(const FollowerCommand& command) noexcept {
  if (!command.valid || !command.q.allFinite() || !std::isfinite(command.jaw)) return;
  command_.q = command.q.cwiseMax(q_min_).cwiseMin(q_max_);
  command_.jaw = command.jaw;
  if (drives_) drives_->aim(command_.q, t_ - t_command_);
  t_command_ = t_;
}

void Follower::discretise(double dt) noexcept {
  dt_ = dt;
  transition_ = servo_transition(2.0 * std::numbers::pi * options_.bandwidth, options_.damping_ratio, dt);
}

void Follower::step(double dt, const Wrench& F_T_B) noexcept {
  t_ += dt;
  jaw_ += std::clamp(command_.jaw - jaw_, -options_.jaw_v_max * dt, options_.jaw_v_max * dt);
  if (drives_) {
    drives_->step(dt, F_T_B);
    return measure();
  }
  if (options_.bandwidth == 0.0) {
    q_ = command_.q;
    return measure();
  }
  if (dt != dt_) discretise(dt);
  for (Eigen::Index k = 0; k < q_.size(); ++k) {
    const double v_max = options_.v_max[k];
    const Eigen::Vector2d next = transition_ * Eigen::Vector2d(q_[k] - command_.q[k], v_[k]);
    const double moved = std::clamp(command_.q[k] + next[0] - q_[k], -v_max * dt, v_max * dt);
    v_[k] = std::clamp(next[1], -v_max, v_max);
    q_[k] = std::clamp(q_[k] + moved, q_min_[k], q_max_[k]);
  }
  measure();
}

void Follower::measure() noexcept {
  measured_.t = t_;
  measured_.q.resize(q_.size());
  for (Eigen::Index k = 0; k < q_.size(); ++k) measured_.q[k] = round_to(q_[k], options_.encoder_step[k]);
  if (drives_) {
    measured_.q = drives_->encoders().q();
    measured_.v = drives_->encoders().v();
    measured_.tau = drives_->tau();
  }
  measured_.jaw = jaw_;
  measured_.valid = true;
}

const FollowerState& Follower::measured() const noexcept { return measured_; }

}  // namespace palpate::plant
