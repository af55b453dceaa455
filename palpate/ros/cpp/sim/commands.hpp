// From the topics that the robot listens to, to commands: the core's table of verbs says which, this says how.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

/// A component's name on the bus, such as MTMR or console.
[[nodiscard]] std::string component_name(const dvrk::System& robot, const dvrk::Address& at);
/// Every component of a kind.
[[nodiscard]] std::vector<dvrk::Address> components(const dvrk::System& robot, dvrk::Kind kind, unsigned arms);

using OnCommand = std::function<void(const dvrk::Command&)>;

/// Subscriptions to every verb of every component; `on_command` is called in the spinner's thread.
[[nodiscard]] std::vector<std::unique_ptr<Entity>> listen(Node& node, const dvrk::System& robot,
                                                          const OnCommand& on_command);

}  // namespace palpate::ros
