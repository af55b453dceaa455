// The guardian: a separate process that sends zero wrenches when the haptic node falls silent.
#pragma once

#include <memory>
#include <string>

#include "haptics/heartbeat.hpp"
#include "rcl/context.hpp"

namespace palpate::ros {

struct GuardianOptions {
  std::string wrench_topic;  ///< topic on which the haptic node publishes wrenches
  std::string node_name;     ///< ROS name of the guardian, which the haptic node accepts as a writer
  int node_pid = 0;          ///< process id of the haptic node
  int beat_fd = -1;          ///< file descriptor of the shared Heartbeat
  double silence = 0.010;    ///< time without a heartbeat after which the guardian takes over [s]
  double period = 0.002;     ///< interval of the checks and of the zero wrenches [s]
  double insist = 1.0;       ///< duration of the zero wrenches after a takeover [s]
};

/// Guards a haptic node until it ends. An arm keeps the last wrench when the sender dies, so the guardian outlives the
/// node and watches both its heartbeat and its process (pidfd). After a takeover the guardian publishes zero wrenches
/// until the node acknowledges (Heartbeat::seen), for at most `insist`. Returns true if the node ended cleanly, false
/// if its process died. Throws if the heartbeat or the process cannot be watched.
bool guard(const std::shared_ptr<Context>& context, const GuardianOptions& options);

}  // namespace palpate::ros
