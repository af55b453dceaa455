#include "palpate/plant/encoders.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace palpate::plant {

namespace {
constexpr double kLongAgo = 1e9;  // [s] before the first edge: the first velocity is zero
}

Encoders::Encoders(const JointMatrix& coupling, JointVector step)
    : A_(coupling), A_inverse_(coupling.inverse()), step_(std::move(step)) {
  reset(JointVector::Zero(step_.size()));
}

void Encoders::reset(const JointVector& q) noexcept {
  v_ = motor_v_ = JointVector::Zero(q.size());
  motor_.noalias() = A_inverse_ * q;
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const double counts = step_[k] > 0.0 ? std::nearbyint(motor_[k] / step_[k]) : 0.0;
    track_[static_cast<std::size_t>(k)] = {motor_[k], counts, counts * step_[k], 0.0, kLongAgo};
    if (step_[k] > 0.0) motor_[k] = counts * step_[k];
  }
  q_.noalias() = A_ * motor_;
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

void Encoders::step(const JointVector& q, double dt) noexcept {
  motor_.noalias() = A_inverse_ * q;
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    Track& track = track_[static_cast<std::size_t>(k)];
    if (step_[k] > 0.0) {
      motor_v_[k] = track.step(motor_[k], step_[k], dt);
      motor_[k] = track.counts * step_[k];
    } else {
      motor_v_[k] = (motor_[k] - track.motor) / dt;
      track.motor = motor_[k];
    }
  }
  q_.noalias() = A_ * motor_;
  v_.noalias() = A_ * motor_v_;
}

}  // namespace palpate::plant
