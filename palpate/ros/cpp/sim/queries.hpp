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
  /// Tells the twin where the base of an arm stands. Does nothing, and returns false, while a query computes.
  bool set_base(int arm, const Pose& X_RB);

 private:
  dvrk::System& twin_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Entity>> services_;
};

}  // namespace palpate::ros
