// Simulated hands and forces end with the client that applies them: a real hand does not stay when its owner leaves.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/subscription.hpp"

namespace palpate::ros {

/// Remembers which publisher holds each arm by hand. A client that ends in order is noticed within 0.1 s, a killed one
/// when DDS gives it up.
class Holders {
 public:
  explicit Holders(const dvrk::System& robot);

  /// Notes the publisher of a command. In the spinner's thread, before the command is handed on.
  void note(const dvrk::Command& command, const std::string& topic, const Gid& publisher);
  /// Looks for publishers that are gone. From a thread that may allocate.
  void look(const Node& node);
  /// Lets go of the arms whose client is gone. In the servo's thread, before it applies commands: does not wait.
  void let_go(dvrk::System& robot) noexcept;

 private:
  struct Hold {
    Gid publisher{};
    std::string topic;
    int absent = 0;  ///< consecutive looks that did not find the publisher
  };
  static constexpr int kAbsent = 2;  // a new publisher may be heard before the graph shows it

  std::mutex mutex_;
  std::vector<std::optional<Hold>> holds_;  ///< by arm
  std::atomic<unsigned> gone_{0};           ///< arms to let go, as bits
};

}  // namespace palpate::ros
