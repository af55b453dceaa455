#include "palpate/loop/link.hpp"

namespace palpate::loop {

void Link::begin(const Pose& X_WT, double jaw) noexcept {
  tool_.X = X_WT;
  tool_.jaw = jaw;
  known_ = true;
}

const RemoteTick* Link::step(double t) noexcept {
  tool_.t = t;
  felt_ = known_ ? &end_->step(tool_) : nullptr;
  return felt_;
}

void Link::remember(Tick& tick, double per_hand) noexcept {
  const Eigen::Quaterniond q(tick.quat_WT[0], tick.quat_WT[1], tick.quat_WT[2], tick.quat_WT[3]);
  const Vec3 p(tick.p_WT[0], tick.p_WT[1], tick.p_WT[2]);
  if (p.allFinite() && q.squaredNorm() > 0.5) begin({Mat3(q), p}, tick.jaw);
  tool_.F = Vec3(tick.F_T_W[0], tick.F_T_W[1], tick.F_T_W[2]);
  if (felt_ == nullptr) return;
  for (int i = 0; i < 3; ++i) {
    tick.p_WR[i] = felt_->p_tool[i];
    tick.F_remote_W[i] = felt_->F_tool[i];
  }
  tick.remote_age = felt_->age;
  tick.remote_delay = felt_->delay;
  tick.remote_link = felt_->linked ? 2.0 : 1.0;
  tick.remote_received = felt_->received;
  tick.energy_model = per_hand * felt_->paid;
  tick.energy_tank = per_hand * felt_->tank;
}

}  // namespace palpate::loop
