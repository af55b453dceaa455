// Subscriptions that turn ROS messages into commands of the simulated robot. The core's table of verbs lists the topics
// and payloads.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

/// All components of a kind; `arms` selects arms by a bit mask of dvrk::ArmKind.
[[nodiscard]] std::vector<dvrk::Address> components(const dvrk::System& robot, dvrk::Kind kind, unsigned arms);

using OnCommand = std::function<void(const dvrk::Command&)>;

/// Subscriptions to every verb of every component; `on_command` is called in the spinner's thread.
[[nodiscard]] std::vector<std::unique_ptr<Entity>> listen(Node& node, const dvrk::System& robot,
                                                          const OnCommand& on_command);

}  // namespace palpate::ros
