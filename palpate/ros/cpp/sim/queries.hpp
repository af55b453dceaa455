// Kinematics on request, beside the running robot: a robot of its own that only counts.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/node.hpp"

namespace palpate::ros {

class Queries {
 public:
  /// `twin`: built as the running robot is, stepped by nobody.
  Queries(Node& node, dvrk::System& twin);
  ~Queries();
  /// The frame of measured_cp has changed.
  void apply(const dvrk::Command& set_base_frame);

 private:
  dvrk::System& twin_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Entity>> services_;
};

}  // namespace palpate::ros
