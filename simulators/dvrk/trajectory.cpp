#include "dvrk/trajectory.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::dvrk {
namespace {

/// Shortest time in which a joint with velocity v0 comes to rest at the distance d (time-optimal control of a double
/// integrator with bounded speed) [s].
double shortest(double d, double v0, double v_max, double a) noexcept {
  const double overshoot = v0 * std::abs(v0) / (2.0 * a);  // displacement of immediate braking
  const double s = d >= overshoot ? 1.0 : -1.0;
  const double way = s * d, speed = s * v0;
  const double peak = std::sqrt(std::max(a * way + 0.5 * speed * speed, 0.0));
  if (peak <= v_max) return (std::max(peak - speed, 0.0) + peak) / a;
  const double t_first = std::abs(v_max - speed) / a, t_last = v_max / a;
  const double rest = way - 0.5 * (speed + v_max) * t_first - 0.5 * v_max * t_last;
  return t_first + t_last + std::max(rest, 0.0) / v_max;
}

/// Displacement of the three phases in the time T, with the cruising speed v_c.
double way_of(double v_c, double v0, double a, double T) noexcept {
  const double t_first = std::abs(v_c - v0) / a, t_last = std::abs(v_c) / a;
  return 0.5 * (v0 + v_c) * t_first + v_c * (T - t_first - t_last) + 0.5 * v_c * t_last;
}

/// The cruising speed whose three phases cover d in the time T, by bisection: the displacement grows with the speed.
double cruise(double d, double v0, double v_max, double a, double T) noexcept {
  double low = std::max(-v_max, 0.5 * (v0 - a * T)), high = std::min(v_max, 0.5 * (v0 + a * T));
  for (int k = 0; k < 60 && high - low > 1e-15; ++k) {
    const double middle = 0.5 * (low + high);
    (way_of(middle, v0, a, T) < d ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

void Trajectory::start(const JointVector& q, const JointVector& v, const JointVector& goal, const JointVector& v_max,
                       const JointVector& a_max) noexcept {
  q0_ = q_ = q;
  v_ = v;
  goal_ = goal;
  t_ = duration_ = 0.0;
  active_ = true;
  done_ = false;
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    duration_ = std::max(duration_, shortest(goal[k] - q[k], v[k], v_max[k], a_max[k]));
  }
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    Phases& p = phases_[static_cast<std::size_t>(k)];
    p.v0 = v[k];
    p.a = a_max[k];
    p.v_c = cruise(goal[k] - q[k], v[k], v_max[k], a_max[k], duration_);
    p.t_first = std::abs(p.v_c - p.v0) / p.a;
    p.t_last = std::abs(p.v_c) / p.a;
  }
}

void Trajectory::step(double dt) noexcept {
  t_ += dt;
  done_ = t_ >= duration_;
  active_ = active_ && !done_;
  if (done_) {
    q_ = goal_;
    v_.setZero();
    return;
  }
  for (Eigen::Index k = 0; k < q_.size(); ++k) {
    const Phases& p = phases_[static_cast<std::size_t>(k)];
    const double left = duration_ - t_;
    if (left <= p.t_last) {  // computed from the end, so that it arrives exactly
      v_[k] = std::copysign(p.a * left, p.v_c);
      q_[k] = goal_[k] - 0.5 * v_[k] * left;
    } else {
      const double t = std::min(t_, p.t_first);
      v_[k] = t < p.t_first ? p.v0 + std::copysign(p.a * t, p.v_c - p.v0) : p.v_c;
      q_[k] = q0_[k] + 0.5 * (p.v0 + v_[k]) * t + p.v_c * (t_ - t);
    }
  }
}

}  // namespace palpate::dvrk
