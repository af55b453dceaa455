// What a loop asks of the operator's end of a link at every tick. The part `network` implements it.
#pragma once

#include "palpate/scene/snapshot.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// The local tool at the end of the last tick, in W.
struct LocalTool {
  double t = 0.0;         ///< time of the tick that begins [s]
  Pose X;                 ///< pose
  double jaw = 0.0;       ///< jaw angle [rad]
  Vec3 F = Vec3::Zero();  ///< contact force on the tool [N]
};

/// What the loop renders in the tick that begins.
struct RemoteTick {
  const scene::Snapshot* scene = nullptr;  ///< objects in place of those of the loop; null: the loop's own
  Vec3 F = Vec3::Zero();                   ///< measured force on the remote tool that the hand feels, in W [N]
  bool linked = false;                     ///< false: the loop holds
  // For the record; energies at the tool's port.
  Vec3 p_tool = Vec3::Zero(), F_tool = Vec3::Zero();  ///< remote tool by its newest packet [m], measured force [N]
  double age = 0.0, delay = 0.0;                      ///< of this packet; until the local motion is executed there [s]
  double received = 0.0;                              ///< packets
  double paid = 0.0, tank = 0.0;                      ///< by updates of the model, and left for more [J]
};

/// The operator's end of a link.
class RemoteEnd {
 public:
  RemoteEnd() = default;
  virtual ~RemoteEnd() = default;
  RemoteEnd(const RemoteEnd&) = delete;
  RemoteEnd& operator=(const RemoteEnd&) = delete;
  /// One tick, without allocation, lock or exception. The result is valid until the next step.
  virtual const RemoteTick& step(const LocalTool& tool) noexcept = 0;
};

}  // namespace palpate::loop
