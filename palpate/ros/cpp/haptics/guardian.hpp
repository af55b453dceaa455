// A process beside the haptic node that does one thing: where the node falls silent, it sends zero wrenches.
#pragma once

#include <memory>
#include <string>

#include "haptics/heartbeat.hpp"
#include "rcl/context.hpp"

namespace palpate::ros {

struct GuardianOptions {
  std::string wrench_topic;  ///< where the node publishes
  std::string node_name;     ///< that the node knows as ours
  int node_pid = 0;
  int beat_fd = -1;
  double silence = 0.010;  ///< of the node, after which the guardian takes over [s]
  double period = 0.002;   ///< between two looks, and between two zeros [s]
  double insist = 1.0;     ///< zeros go on for so long after it has taken over [s]
};

/// A wrench holds on the arm for ever when its sender dies, so this one dies last. Watches the node's heartbeat and its
/// life (pidfd). When it takes over it publishes zeros until the node says that it knows (Heartbeat::seen), or has
/// died. Answers when there is nothing left to guard: true after a good end, false after a death.
bool guard(const std::shared_ptr<Context>& context, const GuardianOptions& options);

}  // namespace palpate::ros
