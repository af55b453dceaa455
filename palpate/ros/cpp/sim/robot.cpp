#include "sim/robot.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace palpate::ros {
namespace {

constexpr double kEnd = 0.1;                  // time between power-off and the end of the threads [s]
constexpr std::int64_t kCatchUp = 30;         // most ticks that are caught up after a delay of the servo thread [-]
constexpr std::int64_t kSearch = 20'000'000;  // interval of the searches for latching clients [ns]
constexpr int kArmTicks = 2;                  // ticks in a period of the arms' controllers [-]
constexpr int kLooks = 3;                     // searches per look for clients that are gone
constexpr std::int64_t kListenWait = 100'000'000;  // longest wait of the subscribing thread [ns]
constexpr int kServo = 70;                         // priority of the servo; the haptic loop has 80
constexpr int kPublish = 69, kListen = 71;         // priorities of the publishing and the subscribing thread

/// Real-time options of a thread on any core, without spinning.
loop::RealTimeOptions at(int priority) noexcept {
  return {.allow_affinity = false, .priority = priority, .spin_us = 0.0};
}

std::int64_t wall_ns() noexcept {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

}  // namespace

Robot::Robot(const std::shared_ptr<Context>& context, dvrk::System& robot, dvrk::System& twin, double rate)
    : robot_(robot),
      every_(std::max(3, static_cast<int>(std::lround(1.0 / (dvrk::System::kTick * rate))))),
      steps_(every_ % kArmTicks == 0 ? kArmTicks : 1),
      node_(context, "dvrk"),
      query_node_(context, "dvrk_queries"),
      queries_(query_node_, twin),
      events_(node_, robot),
      frames_(node_, robot),
      statistics_(node_, robot),
      holders_(robot),
      servo_(at(kServo)) {
  for (int i = 0; i < static_cast<int>(robot.arms().size()); ++i) {
    const std::string& name = robot.arms()[static_cast<std::size_t>(i)];
    arms_.push_back(std::make_unique<ArmMeasures>(node_, name, robot.kind(i), robot.joint_names(i)));
    arm_states_.push_back(std::make_unique<Mailbox<Stamped<dvrk::ArmState>>>());
    bases_.push_back(robot.arm(i).base_frame);
  }
  for (const std::string& name : robot.teleops()) {
    teleops_.push_back(std::make_unique<TeleopMeasures>(node_, name));
    teleop_states_.push_back(std::make_unique<Mailbox<Stamped<dvrk::TeleopState>>>());
  }
  subscriptions_ =
      listen(node_, robot, [this](const dvrk::Command& command, const std::string& topic, const Gid& publisher) {
        ++commands_received_;
        holders_.note(command, topic, publisher);
        commands_.push(command);
      });
  publisher_ = std::thread([this] {
    loop::schedule(at(kPublish));
    publish();
  });
  servo_.start(1.0 / (dvrk::System::kTick * steps_), [this](const loop::Wake& wake) { return tick(wake); });
  spinner_ = std::make_unique<Spinner>(node_, SpinnerOptions{.in_thread = [] { loop::schedule(at(kListen)); },
                                                             .after =
                                                                 [this] {
                                                                   const std::int64_t now = loop::now_ns();
                                                                   statistics_.commands.add(now, now);
                                                                   return kListenWait;
                                                                 }});
  query_spinner_ = std::make_unique<Spinner>(query_node_, SpinnerOptions{.after = [this] {
                                               for (const auto& command : subscriptions_.settings)
                                                 command->find_latching_publisher();
                                               if (++searches_ % kLooks == 0) holders_.look(node_);
                                               return kSearch;
                                             }});
}

void Robot::stop() {
  query_spinner_.reset();
  spinner_.reset();
  servo_.stop();
  if (!publisher_.joinable()) return;
  ending_ = true;
  rounds_.fetch_add(1);
  rounds_.notify_one();
  publisher_.join();
}

bool Robot::tick(const loop::Wake& wake) noexcept {
  const std::int64_t begin = loop::now_ns();
  if (wake.stopping && ticks_left_ < 0) {
    ticks_left_ = static_cast<int>(kEnd / (dvrk::System::kTick * steps_));
    dvrk::Command off;
    off.verb = dvrk::Verb::power_off;
    robot_.apply(off);
  }
  holders_.let_go(robot_);
  dvrk::Command command;
  while (commands_.pop(command)) robot_.apply(command);
  const std::int64_t ticks = steps_ + std::min(steps_ * wake.missed, kCatchUp);
  for (std::int64_t i = 0; i < ticks; ++i) {
    robot_.step();
    if (++ticks_ % every_ == 0) hand_over();
  }
  statistics_.servo.add(begin, loop::now_ns());
  if (ticks_left_ < 0) return true;
  --ticks_left_;
  return ticks_left_ > 0;
}

void Robot::hand_over() noexcept {
  const std::int64_t now = wall_ns();
  const auto when = [&](double t) { return now - static_cast<std::int64_t>(1e9 * (robot_.t() - t)); };
  for (std::size_t i = 0; i < arm_states_.size(); ++i) {
    const dvrk::ArmState& state = robot_.arm(static_cast<int>(i));
    arm_states_[i]->write({state, when(state.t)});
  }
  for (std::size_t i = 0; i < teleop_states_.size(); ++i) {
    const dvrk::TeleopState& state = robot_.teleop(static_cast<int>(i));
    teleop_states_[i]->write({state, when(state.t)});
  }
  Happened happened;
  while (robot_.next(happened.event)) {
    happened.time_ns = when(happened.event.t);
    happened_.push(happened);
  }
  rounds_.fetch_add(1, std::memory_order_release);
  rounds_.notify_one();
}

void Robot::publish() noexcept {
  for (std::uint32_t seen = 0; !ending_;) {
    rounds_.wait(seen, std::memory_order_acquire);
    seen = rounds_.load(std::memory_order_acquire);
    try {
      publish_round();
    } catch (const std::exception& error) {
      node_.problem(std::string("cannot publish: ") + error.what());
    }
  }
}

// An event that cannot be published stays first in the queue and is published later. Events keep their order, so a
// subscriber ends with the right state, although late.
void Robot::publish_round() {
  const std::int64_t now = loop::now_ns();
  for (Happened next; unpublished_ || happened_.pop(next);) {
    if (!unpublished_) unpublished_ = next;
    if (!events_.publish(unpublished_->event, unpublished_->time_ns)) break;
    unpublished_.reset();
  }
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    const auto& [state, time_ns] = arm_states_[i]->read();
    arms_[i]->publish(state, time_ns);
    const bool moved = state.base_frame.p != bases_[i].p || state.base_frame.R != bases_[i].R;
    if (moved && queries_.set_base(static_cast<int>(i), state.base_frame)) bases_[i] = state.base_frame;
  }
  for (std::size_t i = 0; i < teleops_.size(); ++i) {
    const auto& [state, time_ns] = teleop_states_[i]->read();
    teleops_[i]->publish(state, time_ns);
  }
  publish_frames(now);
  statistics_.send(now, wall_ns());
  statistics_.publish.add(now, loop::now_ns());
  rounds_published_.fetch_add(1, std::memory_order_relaxed);
}

void Robot::publish_frames(std::int64_t now) {
  if (!frames_.due(now)) return;
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    const auto& [state, time_ns] = arm_states_[i]->read();
    frames_.add(static_cast<int>(i), state, time_ns);
  }
  frames_.send();
}

}  // namespace palpate::ros
