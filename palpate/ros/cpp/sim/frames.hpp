// Publishes /tf as cisst-ros does: the tip of each arm in the frame of its measured_cp, and the bases that setup joints
// carry, at 50 Hz.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/node.hpp"

namespace palpate::ros {

class Frames {
 public:
  Frames(Node& node, const dvrk::System& robot);
  ~Frames();
  /// Adds the valid poses of an arm to the next message; `time_ns` [ns since 1970].
  void add(int arm, const dvrk::ArmState& state, std::int64_t time_ns);
  /// True if a message is due at a time of the monotonic clock [ns].
  [[nodiscard]] bool due(std::int64_t now) noexcept;
  /// Sends what was added.
  void send();

 private:
  struct Publishing;
  Node& node_;
  std::vector<std::string> arms_;
  std::unique_ptr<Publishing> to_;
  std::int64_t sent_ = 0;
};

/// Frame in which measured_cp of an arm is told.
[[nodiscard]] std::string reference_of(const std::string& arm, const dvrk::ArmState& state);

}  // namespace palpate::ros
