#include "palpate/plant/drive.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/plant/sampling.hpp"
#include "palpate/types/pack.hpp"
#include "palpate/types/random.hpp"

namespace palpate::plant {
namespace {

constexpr double kFade = 0.06;  // [s] time in which the force fades to zero once commands stop: 3 N at 50 N/s

}  // namespace

/// Moves tau by this share towards fade * act + hold, limited to +-tau_max. Where tau_max is zero the result is zero,
/// even if act or hold is not a number.
PALPATE_AVX2_TOO void drive_torques(double fade, double share, const Lanes& response, const Lanes& support,
                                    const Lanes& tau_max, Lanes& tau) noexcept {
  const Pack most = load(tau_max), wanted = fade * load(response) + load(support);
  const Pack goal = min(max(wanted, -most), most);
  store(share == 1.0 ? goal : load(tau) + share * (goal - load(tau)), tau);
}

Drive::Drive(LeaderDriveOptions options)
    : options_(std::move(options)),
      random_(options_.seed),
      line_(static_cast<std::size_t>(std::ceil((options_.delay + options_.jitter) / kShortestPeriod)) + 2) {
  pad(options_.tau_max, tau_max_);
  reset();
}

void Drive::reset() noexcept {
  random_.seed(options_.seed);
  t_ = 0.0;
  t_sent_ = -1.0;
  acting_ = {0.0, JointVector::Zero(options_.tau_max.size())};
  tau_support_ = tau_ = acting_.tau;
  pad(tau_support_, lanes(tau_));
  head_ = size_ = 0;
  settled_ = false;
}

void Drive::command(const LeaderCommand& command) noexcept {
  const JointVector support = command.support_torque(), response = command.response_torque();
  if (!support.allFinite() || !response.allFinite()) return;
  if (t_sent_ < 0.0)
    tau_ = support.cwiseMax(-options_.tau_max)
               .cwiseMin(options_.tau_max);  // the drive held the arm before the first command
  tau_support_ = support;
  settled_ = false;
  if (t_sent_ == t_) --size_;  // of two commands in one servo period the newer one counts
  if (size_ == line_.size()) arrive();
  const std::size_t last = head_ + size_ + line_.size() - 1;
  const double before = size_ > 0 ? line_[last % line_.size()].due : acting_.due;  // no command overtakes another
  const double u = options_.jitter > 0.0 ? uniform(random_) : 0.0;
  line_[(last + 1) % line_.size()] = {std::max(t_ + options_.delay + options_.jitter * u, before), response};
  ++size_;
  t_sent_ = t_;
}

void Drive::arrive() noexcept {
  settled_ = false;
  acting_ = line_[head_];
  head_ = (head_ + 1) % line_.size();
  --size_;
}

const JointVector& Drive::step(double dt) noexcept {
  while (size_ > 0 && line_[head_].due < t_ + 0.5 * dt) arrive();  // rounded to whole servo periods
  const double silent = t_ - acting_.due - options_.hold_timeout;
  const double fade = std::clamp(1.0 - silent / kFade, 0.0, 1.0);
  t_ += dt;
  if (settled_ && fade == fade_) return tau_;
  const double share = options_.lag > 0.0 ? -std::expm1(-dt / options_.lag) : 1.0;
  drive_torques(fade, share, lanes(acting_.tau), lanes(tau_support_), tau_max_, lanes(tau_));
  settled_ = share == 1.0;
  fade_ = fade;
  return tau_;
}

}  // namespace palpate::plant
