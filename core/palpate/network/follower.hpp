// The follower's end with its simulated instrument, in a real-time thread of its own.
#pragma once

#include <atomic>
#include <mutex>

#include "palpate/loop/realtime.hpp"
#include "palpate/loop/ring.hpp"
#include "palpate/network/instrument.hpp"
#include "palpate/network/loop_end.hpp"
#include "palpate/network/site.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::network {

/// Options of the follower.
struct FollowerOptions {
  SiteOptions site;
  InstrumentOptions instrument;
  double rate = 1000.0;  ///< of its loop [Hz]
  loop::RealTimeOptions realtime{.allow_affinity = false, .spin_us = 20.0};
};

/// What other threads may know about the follower.
struct FollowerState : Ages {
  Datagram out;                             ///< the packet that leaves next
  Vec3 x = Vec3::Zero(), F = Vec3::Zero();  ///< true position of the tool [m], and force of the tissue [N]
  double largest = 0.0;                     ///< largest force of the tissue so far [N]
  double account = 0.0;                     ///< energy that the tool may still spend [J]
};

/// Site and instrument in a real-time thread; packets come and go through queues.
class Follower {
 public:
  /// scene: the objects as both ends have them; world: as they really are; X: pose of the tool in W. Throws
  /// std::invalid_argument.
  Follower(const FollowerOptions& options, scene::Snapshot scene, scene::Snapshot world, const Pose& X);

  void start();
  void stop() { thread_.stop(); }
  /// For the thread of the sockets: a packet that arrived at the own time `at` [s]; false if the queue is full.
  bool receive(const Datagram& d, double at) noexcept { return inbox_.push({d, at}); }
  /// The operator has left, or a new one comes.
  void forget_operator() noexcept { forget_ = true; }
  [[nodiscard]] FollowerState state();
  [[nodiscard]] const loop::RealTimeThread& thread() const noexcept { return thread_; }

 private:
  bool wake(const loop::Wake& wake) noexcept;

  FollowerOptions options_;
  Site site_;
  Instrument instrument_;
  loop::Ring<Arrived> inbox_{4096};
  Mailbox<FollowerState> state_;
  std::mutex readers_;
  std::atomic<bool> forget_{false};
  loop::RealTimeThread thread_;
};

}  // namespace palpate::network
