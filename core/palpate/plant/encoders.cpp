#include "palpate/plant/encoders.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/plant/sampling.hpp"
#include "palpate/types/low_pass.hpp"

namespace palpate::plant {

namespace {
constexpr double kLongAgo = 1e9;  // [s] before the first edge: the first velocity is zero
}  // namespace

Encoders::Encoders(const EncoderOptions& options)
    : options_(options),
      A_inverse_(options.coupling.inverse()),
      history_(static_cast<std::size_t>(std::ceil(options.velocity_window / kShortestPeriod)) + 1) {
  reset(JointVector::Zero(options_.step.size()));
}

void Encoders::reset(const JointVector& q) noexcept {
  v_ = motor_v_ = JointVector::Zero(q.size());
  motor_.noalias() = A_inverse_.lazyProduct(q);
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const double counts = options_.step[k] > 0.0 ? std::nearbyint(motor_[k] / options_.step[k]) : 0.0;
    track_[static_cast<std::size_t>(k)] = {motor_[k], counts, counts * options_.step[k], 0.0, kLongAgo};
    if (options_.step[k] > 0.0) motor_[k] = counts * options_.step[k];
  }
  q_.noalias() = options_.coupling.lazyProduct(motor_);
  for (JointVector& motor : history_) motor = motor_;
}

double Encoders::Track::step(double motor_now, double resolution, double dt) noexcept {
  const double counts_now = std::nearbyint(motor_now / resolution);
  const double moved = counts_now - counts;
  since_edge += dt;
  if (moved != 0.0) {
    // Edges lie half-way between counts; the hardware's clock is fine enough to time the last one within the period.
    const double edge_now = (counts_now - std::copysign(0.5, moved)) * resolution;
    const double after = dt * std::clamp((motor_now - edge_now) / (motor_now - motor), 0.0, 1.0);
    v_edges = (edge_now - edge) / std::max(since_edge - after, 1e-9);
    edge = edge_now;
    since_edge = after;
    counts = counts_now;
  }
  motor = motor_now;
  const double bound = resolution / std::max(since_edge, 1e-9);
  return std::clamp(v_edges, -bound, bound);
}

const JointVector& Encoders::earlier(double dt) noexcept {
  newest_ = (newest_ + 1) % history_.size();
  history_[newest_] = motor_;
  const auto back = static_cast<std::size_t>(std::lround(options_.velocity_window / dt));
  return history_[(newest_ + history_.size() - std::min(back, history_.size() - 1)) % history_.size()];
}

void Encoders::step(const JointVector& q, double dt) noexcept {
  motor_.noalias() = A_inverse_.lazyProduct(q);
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    Track& track = track_[static_cast<std::size_t>(k)];
    if (options_.step[k] > 0.0) {
      motor_v_[k] = track.step(motor_[k], options_.step[k], dt);
      motor_[k] = track.counts * options_.step[k];
    } else {
      motor_v_[k] = (motor_[k] - track.motor) / dt;
      track.motor = motor_[k];
    }
  }
  q_.noalias() = options_.coupling.lazyProduct(motor_);
  if (options_.velocity_window > 0.0) motor_v_ = (motor_ - earlier(dt)) / options_.velocity_window;
  const double share = low_pass_coefficient(options_.velocity_cutoff, dt);
  v_ = (1.0 - share) * v_ + share * JointVector(options_.coupling.lazyProduct(motor_v_));
}

}  // namespace palpate::plant
