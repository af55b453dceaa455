// Kinematics services of the simulated dVRK. They compute with a second robot, so that queries never wait for the
// servo.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "dvrk/system.hpp"
#include "rcl/node.hpp"

namespace palpate::ros {

class Queries {
 public:
  /// `twin`: a second instance of the running robot, which is never stepped.
  Queries(Node& node, dvrk::System& twin);
  ~Queries();
  /// Applies a change of the frame of measured_cp to the twin.
  void apply(const dvrk::Command& set_base_frame);

 private:
  dvrk::System& twin_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Entity>> services_;
};

}  // namespace palpate::ros
