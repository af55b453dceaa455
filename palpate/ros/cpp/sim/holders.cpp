#include "sim/holders.hpp"

#include <algorithm>

namespace palpate::ros {
namespace {

using dvrk::Verb;

bool holds(Verb verb) noexcept {
  return verb == Verb::hand_servo_cp || verb == Verb::hand_servo_cf || verb == Verb::tool_servo_cf;
}

}  // namespace

Holders::Holders(const dvrk::System& robot) : holds_(robot.arms().size()) {}

void Holders::note(const dvrk::Command& command, const std::string& topic, const Gid& publisher) {
  if (!holds(command.verb) && command.verb != Verb::hand_free) return;
  const std::lock_guard lock(mutex_);
  gone_ &= ~(1u << command.to.index);
  auto& hold = holds_[static_cast<std::size_t>(command.to.index)];
  if (command.verb == Verb::hand_free) {
    hold.reset();
  } else if (!hold || hold->publisher != publisher) {
    hold = Hold{publisher, topic};
  }
}

void Holders::look(const Node& node) {
  for (std::size_t arm = 0; arm < holds_.size(); ++arm) {
    std::optional<Hold> before;
    {
      const std::lock_guard lock(mutex_);
      before = holds_[arm];
    }
    if (!before) continue;
    const std::vector<Endpoint> ends = node.publishers(before->topic);
    const bool here =
        std::any_of(ends.begin(), ends.end(), [&](const Endpoint& end) { return end.gid == before->publisher; });
    const std::lock_guard lock(mutex_);
    auto& hold = holds_[arm];
    if (!hold || hold->publisher != before->publisher) continue;
    hold->absent = here ? 0 : hold->absent + 1;
    if (hold->absent < kAbsent) continue;
    hold.reset();
    gone_ |= 1u << arm;
  }
}

void Holders::let_go(dvrk::System& robot) noexcept {
  if (gone_.load(std::memory_order_relaxed) == 0) return;
  const unsigned gone = gone_.exchange(0);
  for (int arm = 0; arm < static_cast<int>(holds_.size()); ++arm) {
    if ((gone & (1u << arm)) == 0) continue;
    dvrk::Command free;
    free.to = {dvrk::Kind::arm, arm};
    free.verb = robot.kind(arm) == dvrk::ArmKind::mtm ? Verb::hand_free : Verb::tool_servo_cf;  // a force of zero
    robot.apply(free);
  }
}

}  // namespace palpate::ros
