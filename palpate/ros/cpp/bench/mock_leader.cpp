#include "bench/mock_leader.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "convert.hpp"

namespace palpate::ros {
namespace {

using loop::now_ns;
constexpr Qos kReliable{.depth = 10};

double now() noexcept { return 1e-9 * static_cast<double>(now_ns()); }

double wall() noexcept {
  timespec t{};
  clock_gettime(CLOCK_REALTIME, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

builtin_interfaces::msg::Time stamped(double seconds) noexcept { return stamp(std::llround(1e9 * seconds)); }

}  // namespace

MockLeader::MockLeader(std::shared_ptr<Context> context, const MockLeaderOptions& options)
    : options_(options),
      node_(std::move(context), "palpate_mock_leader"),
      pose_(node_, "/" + options.leader + "/measured_cp", Qos{.depth = 10, .reliable = options.reliable}),
      twist_(node_, "/" + options.leader + "/measured_cv", kReliable),
      joints_(node_, "/" + options.leader + "/measured_js", kReliable),
      state_(node_, "/" + options.leader + "/operating_state", kLatched),
      following_(node_, "/" + options.teleop + "/following", kLatched),
      absolute_sub_(node_, "/" + options.leader + "/body/set_cf_orientation_absolute",
                    [this](const auto& m, const Info&) {
                      absolute_ = m.data;
                      frame_settings_.add({now(), m.data ? 1.0 : 0.0});
                    }),
      gravity_sub_(node_, "/" + options.leader + "/use_gravity_compensation",
                   [this](const auto& m, const Info&) { gravity_compensation_ = m.data; }),
      wrench_(
          node_, options.wrench,
          [this](const auto& m, const Info& info) {
            const auto &f = m.wrench.force, &torque = m.wrench.torque;
            const double stamp = 1e-9 * static_cast<double>(nanoseconds(m.header.stamp));
            ReceivedWrench received{now(), wall(), stamp, {f.x, f.y, f.z}, {torque.x, torque.y, torque.z}};
            received.writer = writer(info.publisher);
            received.absolute = absolute_ ? 1.0 : 0.0;
            received.sequence = static_cast<double>(info.sequence);
            wrenches_.add(received);
          },
          Qos{.depth = 100}),
      clock_({.allow_priority = true, .allow_affinity = false, .spin_us = 0.0}),
      random_(options.seed) {
  from_ = to_ = amplitude_ = Vec3::Zero();
  joints_message_.name = {"j1", "j2", "j3", "j4", "j5", "j6", "j7"};
  if (options.echo) {
    there_.emplace(node_, "/palpate_there");
    back_.emplace(node_, "/palpate_back", [this](const auto& m, const Info&) {
      echoes_.add(wall() - 1e-9 * static_cast<double>(nanoseconds(m.header.stamp)));
    });
  }
  SpinnerOptions spinning;
  spinning.in_thread = [] { loop::schedule({.allow_priority = true, .allow_affinity = false, .spin_us = 0.0}); };
  spinning.direct = true;
  spinner_.emplace(node_, std::move(spinning));
}

MockLeader::~MockLeader() { stop(); }

void MockLeader::start() {
  const double rate = options_.echo ? 2.0 * options_.rate : options_.rate;
  clock_.start(rate, [this](const loop::Wake& wake) { return tick(wake); });
}

void MockLeader::stop() { clock_.stop(); }

bool MockLeader::tick(const loop::Wake& wake) {
  if (wake.stopping) return false;
  if (options_.echo && tick_++ % 2 == 1) {
    ping();
  } else {
    send(now());
  }
  return true;
}

double MockLeader::writer(const Gid& publisher) {
  const auto found = std::find(writers_.begin(), writers_.end(), publisher);
  const auto index = found - writers_.begin();
  if (found == writers_.end()) writers_.push_back(publisher);
  return static_cast<double>(index);
}

Vec3 MockLeader::position(double t) const {
  const double share = seconds_ > 0.0 ? std::clamp((t - begin_) / seconds_, 0.0, 1.0) : 1.0;
  const double soft = share * share * (3.0 - 2.0 * share);
  return from_ + soft * (to_ - from_) + std::sin(2.0 * std::numbers::pi * frequency_ * t) * amplitude_;
}

// Publishes one state, with the faults that are set.
void MockLeader::send(double t) {
  MessageFaults faults;
  Vec3 p;
  {
    const std::lock_guard lock(mutex_);
    faults = faults_;
    p = position(t);
    const Eigen::Vector4d quat = faults.no_rotation ? Eigen::Vector4d::Zero() : quat_;
    auto& turn = message_.pose.orientation;
    turn.x = quat.x(), turn.y = quat.y(), turn.z = quat.z(), turn.w = quat.w();
  }
  const auto chance = [this](double share) {
    return share > 0.0 && std::uniform_real_distribution<>()(random_) < share;
  };
  const double stamp = wall() + faults.clock;
  put(p, message_.pose.position);
  if (faults.not_finite) message_.pose.position.y = std::numeric_limits<double>::quiet_NaN();
  message_.header.stamp = faults.zero_stamp ? builtin_interfaces::msg::Time{} : stamped(stamp);
  while (!late_.empty() && late_.front().due <= t) {
    static_cast<void>(pose_.publish(late_.front().pose));
    late_.pop_front();
  }
  if (faults.silent || chance(faults.drop)) return;
  send_joints(stamp, faults);
  if (faults.delay > 0.0) {
    late_.push_back({t + faults.delay, message_});
    return;
  }
  if (!held_ && chance(faults.swap)) {
    held_ = message_;  // published after the next state
    return;
  }
  const double before = now();
  const bool done = static_cast<bool>(pose_.publish(message_));
  if (done && chance(faults.twice)) static_cast<void>(pose_.publish(message_));
  if (const auto held = std::exchange(held_, std::nullopt)) static_cast<void>(pose_.publish(*held));
  sent_.add(before);
}

void MockLeader::send_joints(double stamp, const MessageFaults& faults) {
  if (!faults.wrong_length) return;  // joint states are sent only to test wrong lengths
  joints_message_.header.stamp = stamped(stamp);
  joints_message_.position.assign(joints_message_.position.empty() ? 3 : 0, 0.1);
  static_cast<void>(joints_.publish(joints_message_));
}

void MockLeader::ping() {
  if (!there_ || !back_ || there_->listeners() == 0 || back_->publishers() == 0) return;  // the echo is not found yet
  ping_.header.stamp = stamped(wall());
  if (there_->publish(ping_)) ++pings_;
}

void MockLeader::move_to(const Vec3& p, double seconds) {
  const std::lock_guard lock(mutex_);
  const double t = now();
  from_ = position(t) - std::sin(2.0 * std::numbers::pi * frequency_ * t) * amplitude_;
  to_ = p, begin_ = t, seconds_ = seconds;
}

void MockLeader::swing(const Vec3& amplitude, double frequency) {
  const std::lock_guard lock(mutex_);
  amplitude_ = amplitude, frequency_ = frequency;
}

void MockLeader::turn_to(const Eigen::Vector4d& quat) {
  const std::lock_guard lock(mutex_);
  quat_ = quat.normalized();
}

void MockLeader::inject(const MessageFaults& faults) {
  const std::lock_guard lock(mutex_);
  faults_ = faults;
}

void MockLeader::set_state(const std::string& state, bool homed) {
  crtk_msgs::msg::OperatingState message;
  message.header.stamp = stamped(wall());
  message.state = state, message.is_homed = homed;
  if (const Status done = state_.publish(message); !done) throw Error(done.problem);
}

void MockLeader::follow(bool on) {
  std_msgs::msg::Bool message;
  message.data = on;
  if (const Status done = following_.publish(message); !done) throw Error(done.problem);
}

}  // namespace palpate::ros
