#include "palpate/loop/crtk_watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/types/status.hpp"

namespace palpate::loop {
namespace {

constexpr double kFarthest = 100.0;    // [m] larger coordinates are rejected
constexpr double kLongest = 0.1;       // [s] after a longer silence the motion since then is not checked
constexpr double kPeriodShare = 0.05;  // weight of a new period in the running mean

}  // namespace

bool Watch::refuse(unsigned bits) noexcept {
  faults_ |= bits;
  return false;
}

unsigned Watch::take_faults() noexcept { return std::exchange(faults_, 0u); }

bool Watch::stale(ClockTime now) const noexcept {
  const double silence = now.t - t_, late = std::abs(now.wall - stamp_);
  return !received_ || !(silence <= options_.stale_after) || !(late <= options_.stale_after);
}

bool Watch::stamp(double stamp, ClockTime now) noexcept {
  if (!(stamp > 0.0) || !std::isfinite(stamp)) return refuse(kBadStamp);
  age_ = now.wall - stamp;
  const double ahead = stamp - stamp_, passed = now.t - t_;
  const bool near = std::abs(age_) <= options_.stale_after;
  if (received_ && ahead <= 0.0 && -ahead <= options_.stale_after) {
    ++ignored_;
    return false;
  }
  if (received_ && near && std::abs(ahead - passed) > options_.stale_after) {
    faults_ |= kClockJumped;  // stamps and monotonic clock disagree on the time elapsed
  }
  if (!near) return refuse(kBadStamp);
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
  const bool finite = (p.array().abs() < kFarthest).all() && std::abs(quat.squaredNorm() - 1.0) < 0.01;
  if (!finite) return refuse(kNotFinite);
  const Pose next{Eigen::Quaterniond(quat[3], quat[0], quat[1], quat[2]).normalized().toRotationMatrix(), p};
  const double turned = std::acos(std::clamp(0.5 * ((X_.R.transpose() * next.R).trace() - 1.0), -1.0, 1.0));
  const bool jumped = placed_ && ((p - X_.p).norm() > options_.v_max * interval_ + options_.p_slack ||
                                  turned > options_.w_max * interval_ + options_.R_slack);
  if (jumped) faults_ |= kJumped;
  placed_ = true;
  X_ = X = next;
  return true;
}

}  // namespace palpate::loop
