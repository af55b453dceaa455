#include "palpate/loop/execution.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::loop {

void PlannedMotion::at(double t, JointVector& out) const noexcept {
  const double place = std::clamp(t / dt, 0.0, static_cast<double>(q.cols() - 1));
  const Eigen::Index k = std::min(static_cast<Eigen::Index>(place), q.cols() - 2);
  const double s = place - static_cast<double>(k), s2 = s * s, s3 = s2 * s;
  out = (2.0 * s3 - 3.0 * s2 + 1.0) * q.col(k) + (3.0 * s2 - 2.0 * s3) * q.col(k + 1);
  out += dt * ((s3 - 2.0 * s2 + s) * v.col(k) + (s3 - s2) * v.col(k + 1));
}

void check(const PlannedMotion& motion) {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("planned motion: " + what); };
  if (!(motion.dt > 0.0 && std::isfinite(motion.dt)))
    refuse("dt = " + std::to_string(motion.dt) + " must be above 0 s");
  if (motion.q.cols() < 2 || motion.q.rows() < 1 || motion.q.rows() > kMaxJoints) {
    refuse("q must have two columns or more, and a row for each joint");
  }
  if (motion.v.rows() != motion.q.rows() || motion.v.cols() != motion.q.cols()) refuse("v must have the shape of q");
  if (motion.levers.size() != motion.q.rows() || !(motion.levers.array() > 0.0).all()) {
    refuse("levers must have a number above 0 for each joint");
  }
  if (!motion.q.allFinite() || !motion.v.allFinite() || !motion.levers.allFinite()) refuse("all values must be finite");
}

void check(const ExecutionOrder& order) {
  if (!(order.pace >= 0.0 && order.pace <= 1.0) || !(order.until >= 0.0) || !(order.guard >= 0.0)) {
    throw std::invalid_argument("execution: pace must lie in 0..1, until and guard must be 0 or more; got " +
                                std::to_string(order.pace) + ", " + std::to_string(order.until) + " s, " +
                                std::to_string(order.guard) + " N");
  }
}

bool Execution::step(const PlannedMotion& motion, const ExecutionOrder& order, bool executing,
                     JointVector& q) noexcept {
  if (motion.number != number_ && !moves()) take(motion);
  if (number_ == 0 || motion.number != number_) return false;
  if (order.motion == number_ && order.stop) stop(ExecutionPhase::stopped);
  if (begun_ && !executing) stop(ExecutionPhase::released);
  if (wanted() && !begun_) wait(motion, q, executing);
  if (!begun_ || !(wanted() || moves())) return false;

  const double end = motion.duration();
  time_ = std::min(time_ + pace_.step(wanted_pace(order, end), dt_), end);
  if (time_ >= end) {
    pace_.reset();
    stop(ExecutionPhase::done);
  }
  motion.at(time_, q);
  blend_ = std::min(blend_ + dt_, kBlend);
  const double s = blend_ / kBlend;
  q += (1.0 - s * s * (3.0 - 2.0 * s)) * offset_;
  return true;
}

void Execution::take(const PlannedMotion& motion) noexcept {
  number_ = motion.number;
  phase_ = ExecutionPhase::moving;
  begun_ = false;
  pace_.reset();
  time_ = waited_ = blend_ = 0.0;
}

// Begins the motion in the state `executing`, if the goal of the joints is at its start.
void Execution::wait(const PlannedMotion& motion, const JointVector& q, bool executing) noexcept {
  waited_ += dt_;
  if (!executing && waited_ > kPatience) stop(ExecutionPhase::released);
  if (!executing) return;
  if (motion.q.rows() == q.size()) {
    offset_ = q - motion.q.col(0);
    begun_ = (offset_.array().abs() * motion.levers.array()).sum() <= kNear;
  }
  if (!begun_) stop(ExecutionPhase::elsewhere);
}

// The pace that was ordered, limited so that the motion can rest at the end of its free part.
double Execution::wanted_pace(const ExecutionOrder& order, double end) const noexcept {
  if (phase_ != ExecutionPhase::moving || order.motion != number_) return 0.0;
  const double pace = std::clamp(order.pace, 0.0, 1.0);
  if (order.until >= end - kSameTime) return pace;  // the plan itself ends at rest
  return std::min(pace, pace_.limit(order.until - time_ - dt_));
}

}  // namespace palpate::loop
