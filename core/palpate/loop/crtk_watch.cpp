#include "palpate/loop/crtk_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "palpate/types/so3.hpp"
#include "palpate/types/status.hpp"

namespace palpate::loop {
namespace {

constexpr double kFarthest = 10.0;     // [m] larger coordinates are rejected; millimetres taken for metres exceed it
constexpr double kLongest = 0.1;       // [s] after a longer silence the motion since then is not checked
constexpr double kPeriodShare = 0.05;  // weight of a new period in the running mean
constexpr double kWindow = 0.5;        // [s] half of the time over which the smallest age is sought
constexpr double kNoise = 1e-4;        // [m] smaller displacements are noise, whichever way they lead
constexpr double kLever = 0.05;        // [m/rad] at which rotations count as displacements
constexpr double kZigzagFade = 0.02;   // [s] in which what was travelled to and fro fades
constexpr double kZigzag = 0.008;      // [m] more than a hand travels to and fro in that time

}  // namespace

void ClockOffset::add(double age, double t) noexcept {
  if (!known_ || t - begin_ > 2.0 * kWindow) {
    before_ = least_ = age;
    begin_ = t;
  } else if (t - begin_ > kWindow) {
    before_ = std::exchange(least_, age);
    begin_ = t;
  }
  known_ = true;
  least_ = std::min(least_, age);
}

bool Watch::refuse(std::uint64_t bit, double value, double other) noexcept {
  faults_.bits |= bit;
  faults_.cause = {bit, value, other};
  return false;
}

Faults Watch::take_faults() noexcept { return std::exchange(faults_, {}); }

double Watch::silence(ClockTime now) const noexcept {
  return heard_ ? now.t - heard_at_ : std::numeric_limits<double>::infinity();
}

bool Watch::stale(ClockTime now) const noexcept { return !(silence(now) <= options_.stale_after); }

bool Watch::stamp(double stamp, ClockTime now) noexcept {
  const bool valid = stamp > 0.0 && std::isfinite(stamp);
  const double ahead = stamp - stamp_, passed = now.t - t_;
  const bool near = std::abs(now.wall - stamp) <= options_.stale_after;
  if (received_ && (ahead == 0.0 || (near && ahead < 0.0 && -ahead <= options_.stale_after))) {
    ++ignored_;
    return false;
  }
  heard_ = true;
  heard_at_ = now.t;
  if (!valid) return refuse(kBadStamp, stamp);
  age_ = now.wall - stamp;
  offset_.add(age_, now.t);
  if (!near) return refuse(kClockOffset, -age_, options_.stale_after);
  if (received_ && std::abs(ahead - passed) > options_.stale_after) {
    refuse(kClockJumped, ahead - passed);  // stamps and monotonic clock disagree on the time elapsed
  }
  interval_ = received_ ? std::clamp(ahead, 0.0, kLongest) : 0.0;
  if (received_) period_ += (period_ > 0.0 ? kPeriodShare : 1.0) * (std::clamp(passed, 0.0, 1.0) - period_);
  placed_ = placed_ && ahead <= kLongest && ahead > 0.0;
  received_ = true;
  t_ = now.t;
  stamp_ = stamp;
  ++accepted_;
  return true;
}

bool Watch::pose(const Vec3& p, const Eigen::Vector4d& quat, Pose& X) noexcept {
  if (!p.allFinite() || !quat.allFinite()) return refuse(kNotFinite);
  if ((p.array().abs() > kFarthest).any()) return refuse(kTooFar, p.cwiseAbs().maxCoeff(), kFarthest);
  if (std::abs(quat.squaredNorm() - 1.0) > 0.01) return refuse(kNotRotation, quat.stableNorm());
  const Pose next{Eigen::Quaterniond(quat[3], quat[0], quat[1], quat[2]).normalized().toRotationMatrix(), p};
  check_motion(next);
  placed_ = true;
  X_ = X = next;
  return true;
}

// Is the way from the last pose one that a hand can travel?
void Watch::check_motion(const Pose& next) noexcept {
  step_age_ += interval_;
  zigzag_ *= std::exp(-interval_ / kZigzagFade);
  if (!placed_) {
    step_.setZero();
    return;
  }
  Vec6 step;
  step << next.p - X_.p, kLever * rotation_vector(Mat3(next.R * X_.R.transpose()));
  const double moved = step.head<3>().norm(), turned = step.tail<3>().norm() / kLever;
  if (moved > options_.v_max * interval_ + options_.p_slack || turned > options_.w_max * interval_ + options_.R_slack) {
    refuse(kJumped, moved, turned);
  }
  const double length = step.norm();
  if (length <= kNoise) return;
  if (step_age_ <= kZigzagFade && step.dot(step_) < 0.0) {
    const double back = std::min(length, step_.norm());
    zigzag_ = std::min(zigzag_ + back, 2.0 * kZigzag);
    if (zigzag_ > kZigzag) refuse(kAlternating, back);
  }
  step_ = step;
  step_age_ = 0.0;
}

}  // namespace palpate::loop
