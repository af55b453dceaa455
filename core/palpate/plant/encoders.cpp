#include "palpate/plant/encoders.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/plant/sampling.hpp"
#include "palpate/types/low_pass.hpp"
#include "palpate/types/pack.hpp"

namespace palpate::plant {

namespace {

constexpr double kLongAgo = 1e9;  // [s] before the first edge: the first velocity is zero

void take_columns(const JointMatrix& A, Lanes (&columns)[kLanes]) noexcept {
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    for (Eigen::Index i = 0; i < A.rows(); ++i) columns[j][i] = A(i, j);
  }
}

}  // namespace

/// y <- A x, where the columns of A are given.
PALPATE_AVX2_TOO void multiply(const Lanes (&columns)[kLanes], const Lanes& x, Lanes& y) noexcept {
  store(product(columns, x), y);
}

/// v <- v_edges within +-step / since_edge.
PALPATE_AVX2_TOO void bound(const Lanes& v_edges, const Lanes& since_edge, const Lanes& step, Lanes& v) noexcept {
  const Pack most = load(step) / max(load(since_edge), constant(1e-9));
  store(min(max(load(v_edges), -most), most), v);
}

/// Moves the encoders from edge to edge, where the counts have changed in this period: the nearest whole numbers of
/// motor / step, to even when half-way, for fewer than 2^51 counts. Edges lie half-way between counts; the hardware's
/// clock is fine enough to time the last one within the period.
PALPATE_AVX2_TOO void Encoders::pass_edges(const Lanes (&inverse)[kLanes], const Lanes& step, const Lanes& q, double dt,
                                           Tracks& track) noexcept {
  const Pack zero = {}, half = constant(0.5), round = constant(0x1.8p52), position = product(inverse, q);
  const Pack now = (position / load(step) + round) - round, moved = now - load(track.counts);
  const Pack changes = moved * moved, since = load(track.since_edge) + constant(dt), edge_before = load(track.edge);
  const Pack edge = (now - where_at_most(moved, zero, -half, half)) * load(step);
  const Pack before = load(track.motor), share = (position - edge) / (position - before);
  const Pack after = dt * min(max(share, zero), constant(1.0));
  const Pack v = (edge - edge_before) / max(since - after, constant(1e-9));
  store(where_at_most(changes, zero, load(track.v_edges), v), track.v_edges);
  store(where_at_most(changes, zero, edge_before, edge), track.edge);
  store(where_at_most(changes, zero, since, after), track.since_edge);
  store(now, track.counts);
  store(before, track.motor_before);
  store(position, track.motor);
}

Encoders::Encoders(const EncoderOptions& options)
    : options_(options),
      q_(JointVector::Zero(options.step.size())),
      v_(q_),
      motor_(q_),
      motor_v_(q_),
      history_(static_cast<std::size_t>(std::ceil(options.velocity_window / kShortestPeriod)) + 1, q_) {
  take_columns(options_.coupling, coupling_);
  take_columns(options_.coupling.inverse(), inverse_);
  std::fill(step_, step_ + kLanes, 1.0);
  for (Eigen::Index k = 0; k < options_.step.size(); ++k) {
    if (options_.step[k] > 0.0) step_[k] = options_.step[k];
    ideal_ |= !(options_.step[k] > 0.0);
  }
  every_period_ = ideal_ || options_.velocity_window > 0.0 || options_.velocity_cutoff > 0.0;
  reset(q_);
}

void Encoders::reset(const JointVector& q) noexcept {
  alignas(64) Lanes joints;
  pad(q, joints);
  multiply(inverse_, joints, lanes(motor_));
  v_.setZero();
  motor_v_.setZero();
  track_ = {};
  for (Eigen::Index k = 0; k < q_.size(); ++k) {
    track_.motor[k] = motor_[k];
    track_.since_edge[k] = kLongAgo;
    if (!(options_.step[k] > 0.0)) continue;
    track_.counts[k] = std::nearbyint(motor_[k] / step_[k]);
    motor_[k] = track_.edge[k] = track_.counts[k] * step_[k];
  }
  multiply(coupling_, lanes(motor_), lanes(q_));
  for (JointVector& motor : history_) motor = motor_;
}

const JointVector& Encoders::earlier(double dt) noexcept {
  newest_ = (newest_ + 1) % history_.size();
  history_[newest_] = motor_;
  const auto back = static_cast<std::size_t>(std::lround(options_.velocity_window / dt));
  return history_[(newest_ + history_.size() - std::min(back, history_.size() - 1)) % history_.size()];
}

void Encoders::step(const Lanes& q, double dt) noexcept {
  pass_edges(inverse_, step_, q, dt, track_);
  if (every_period_) estimate(dt);
}

void Encoders::read() noexcept {
  if (!every_period_) estimate(0.0);
}

void Encoders::estimate(double dt) noexcept {
  bound(track_.v_edges, track_.since_edge, step_, lanes(motor_v_));
  for (int k = 0; k < kLanes; ++k) motor_.data()[k] = track_.counts[k] * step_[k];
  for (Eigen::Index k = 0; ideal_ && k < q_.size(); ++k) {
    if (options_.step[k] > 0.0) continue;
    motor_[k] = track_.motor[k];
    motor_v_[k] = (track_.motor[k] - track_.motor_before[k]) / dt;
  }
  multiply(coupling_, lanes(motor_), lanes(q_));
  if (options_.velocity_window > 0.0) motor_v_ = (motor_ - earlier(dt)) / options_.velocity_window;
  if (options_.velocity_cutoff == 0.0) return multiply(coupling_, lanes(motor_v_), lanes(v_));
  const double share = low_pass_coefficient(options_.velocity_cutoff, dt);
  alignas(64) Lanes v;
  multiply(coupling_, lanes(motor_v_), v);
  for (int k = 0; k < kLanes; ++k) v_.data()[k] = (1.0 - share) * v_.data()[k] + share * v[k];
}

}  // namespace palpate::plant
