#include "palpate/plant/drive.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::plant {
namespace {

constexpr double kShortestPeriod = 1e-5;  // [s] the delay line is long enough for it
constexpr double kFade = 0.06;            // [s] from full force to none once the commands stop: 3 N at 50 N/s

std::size_t periods(double delay, double dt) noexcept { return static_cast<std::size_t>(std::lround(delay / dt)); }

}  // namespace

Drive::Drive(double delay, double hold_timeout, JointVector tau_max)
    : delay_(delay),
      hold_timeout_(hold_timeout),
      tau_max_(std::move(tau_max)),
      line_(periods(delay, kShortestPeriod) + 1) {
  reset();
}

void Drive::reset() noexcept {
  tau_force_ = tau_hold_ = tau_ = JointVector::Zero(tau_max_.size());
  for (JointVector& tau : line_) tau = tau_force_;
  age_ = 0.0;
}

void Drive::command(const LeaderCommand& command) noexcept {
  const JointVector hold = command.hold(), act = command.act();
  if (!hold.allFinite() || !act.allFinite()) return;
  tau_force_ = act;
  tau_hold_ = hold;
  age_ = 0.0;
}

const JointVector& Drive::step(double dt) noexcept {
  const double fade = std::clamp(1.0 - (age_ - hold_timeout_) / kFade, 0.0, 1.0);
  line_[head_] = fade * tau_force_;
  const std::size_t back = std::min(periods(delay_, dt), line_.size() - 1);
  tau_ = (line_[(head_ + line_.size() - back) % line_.size()] + tau_hold_).cwiseMax(-tau_max_).cwiseMin(tau_max_);
  head_ = (head_ + 1) % line_.size();
  age_ += dt;
  return tau_;
}

}  // namespace palpate::plant
