#include "palpate/plant/follower.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

#include "palpate/types/pack.hpp"
#include "palpate/types/servo.hpp"

namespace palpate::plant {
namespace {

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

/// One step of the joints' servos towards `goal`, within the limits. phi: transition of (position - goal, velocity).
PALPATE_AVX2_TOO void servo_step(const Follower::Joints& joints, const double (&phi)[4], double dt, const Lanes& goal,
                                 Lanes& q, Lanes& v) noexcept {
  const Pack aim = load(goal), before = load(q), error = before - aim, speed = load(v);
  const Pack v_max = load(joints.v_max), reach = dt * v_max;
  const Pack moved = aim + (phi[0] * error + phi[1] * speed) - before;
  store(min(max(phi[2] * error + phi[3] * speed, -v_max), v_max), v);
  store(min(max(before + min(max(moved, -reach), reach), load(joints.q_min)), load(joints.q_max)), q);
}

/// Positions in whole steps of the encoders, to even when half-way, for fewer than 2^51 steps. Steps of zero: ideal.
PALPATE_AVX2_TOO void round_to_steps(const Lanes& q, const Lanes& step, Lanes& rounded) noexcept {
  constexpr double kRound = 0x1.8p52;
  const Pack x = load(q), s = load(step);
  const Pack y = s * ((x / s + constant(kRound)) - constant(kRound));
  store(where_at_most(s, constant(0.0), x, y), rounded);
}

Follower::Follower(const arm::Arm& model, FollowerOptions options)
    : options_(std::move(options)), q_min_(model.q_min()), q_max_(model.q_max()) {
  check(options_, q_min_.size());
  pad(options_.v_max, joints_.v_max);
  pad(options_.encoder_step, joints_.step);
  pad(q_min_, joints_.q_min);
  pad(q_max_, joints_.q_max);
  if (options_.driven) {
    drives_.emplace(model, options_.drives, options_.bandwidth, options_.damping_ratio, options_.encoder_step);
  }
  reset(JointVector::Zero(q_min_.size()), 0.0);
}

void Follower::reset(const JointVector& q, double jaw) noexcept {
  for (JointVector* x : {&q_, &v_, &command_.q, &measured_.q}) {
    x->resize(q_min_.size());
    std::fill_n(lanes(*x), kLanes, 0.0);
  }
  q_ = q.cwiseMax(q_min_).cwiseMin(q_max_);
  if (drives_) drives_->reset(q_);
  command_.q = q_;
  command_.jaw = jaw;
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
  const Eigen::Matrix2d phi = servo_transition(2.0 * std::numbers::pi * options_.bandwidth, options_.damping_ratio, dt);
  transition_[0] = phi(0, 0), transition_[1] = phi(0, 1), transition_[2] = phi(1, 0), transition_[3] = phi(1, 1);
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
  servo_step(joints_, transition_, dt, lanes(command_.q), lanes(q_), lanes(v_));
  measure();
}

void Follower::measure() noexcept {
  measured_.t = t_;
  if (drives_) {
    measured_.q = drives_->encoders().q();
    measured_.v = drives_->encoders().v();
    measured_.tau = drives_->tau();
  } else {
    round_to_steps(lanes(q_), joints_.step, lanes(measured_.q));
  }
  measured_.jaw = jaw_;
  measured_.valid = true;
}

const FollowerState& Follower::measured() const noexcept { return measured_; }

}  // namespace palpate::plant
