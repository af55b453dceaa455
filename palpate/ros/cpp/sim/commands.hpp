// Subscriptions that turn ROS messages into commands of the simulated robot. The core's table of verbs lists the topics
// and payloads.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/latched_subscriber.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

/// Called with a command, its full topic and its publisher, which is unknown (zero) for settings.
using OnCommand = std::function<void(const dvrk::Command&, const std::string& topic, const Gid& publisher)>;

/// Subscriptions to every verb of every component. CRTK's clients latch commands that are settings, such as
/// state_command, so that DDS keeps those that were sent before it has connected client and robot.
struct Subscriptions {
  std::vector<std::unique_ptr<Entity>> motions;
  std::vector<std::unique_ptr<LatchingSearch>> settings;
};

/// `on_command` is called in the spinner's thread.
[[nodiscard]] Subscriptions listen(Node& node, const dvrk::System& robot, const OnCommand& on_command);

}  // namespace palpate::ros
