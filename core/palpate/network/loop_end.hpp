// The operator's end inside a haptic loop: packets come and go through queues, and the loop waits for nobody.
#pragma once

#include <cstdint>
#include <mutex>
#include <vector>

#include "palpate/loop/remote_end.hpp"
#include "palpate/loop/ring.hpp"
#include "palpate/network/modes.hpp"
#include "palpate/network/operator.hpp"
#include "palpate/network/peer.hpp"
#include "palpate/network/port.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::network {

/// A packet, and when it arrived on the own clock [s].
struct Arrived {
  Datagram d;
  double at = 0.0;
};

/// Options of the operator's end in a loop.
struct LoopEndOptions : EndOptions {
  UpdateOptions update;
};

/// What other threads may know about the link.
struct LinkState : Ages {
  Datagram out;           ///< the packet that leaves next
  Datagram newest;        ///< the newest packet of the other end
  double offset = 0.0;    ///< clock of the other end minus the own one [s]
  double drift = 0.0;     ///< of the other clock [-]
  double bound = 0.0;     ///< error of the offset by an unknown asymmetry [s]
  double held = 0.0;      ///< time without link after the first [s]
  double received = 0.0;  ///< packets
  bool known = false, linked = false, outage = false;
  std::vector<ModelEstimate> models;  ///< as rendered, one for each object
  double tank = 0.0;                  ///< least energy in the tanks of the objects [J]
  double paid = 0.0;                  ///< energy that updates have added to the springs, less what they took [J]
};

/// The hand feels the local model, or the measured force as far as the energies of both ports allow. While the link is
/// down the loop holds; its own ramps end and begin the force.
class LoopEnd final : public loop::RemoteEnd {
 public:
  LoopEnd(const LoopEndOptions& options, scene::Snapshot scene);

  /// For the thread of the sockets: a packet that arrived at the own time `at` [s]; false if the queue is full.
  bool receive(const Datagram& d, double at) noexcept { return inbox_.push({d, at}); }
  /// For other threads: the state after the newest tick.
  [[nodiscard]] LinkState state();

  const loop::RemoteTick& step(const loop::LocalTool& tool) noexcept override;
  /// The same at the own time `now` [s], for loops in virtual time.
  const loop::RemoteTick& step_at(const loop::LocalTool& tool, double now) noexcept;
  /// For the thread of the loop: the packet that leaves after the newest tick.
  [[nodiscard]] const Datagram& packet() const noexcept { return now_.out; }

 private:
  void link() noexcept;
  void feel(const loop::LocalTool& tool, double now, double dt) noexcept;
  void publish(const loop::LocalTool& tool, double now) noexcept;

  LoopEndOptions options_;
  LocalModel model_;
  scene::Snapshot empty_;
  Peer peer_;
  Port port_;
  loop::Ring<Arrived> inbox_{1024};
  Mailbox<LinkState> state_;
  std::mutex readers_;
  LinkState now_;
  loop::RemoteTick out_;
  Vec3 p_ = Vec3::Zero(), v_ = Vec3::Zero();
  double t_ = -1.0;
};

}  // namespace palpate::network
