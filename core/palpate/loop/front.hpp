// The interface between a running loop and other threads: they change controls, scene and fixtures and read ticks. The
// loop never waits for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "palpate/contact/tool.hpp"
#include "palpate/guidance/interface/stage.hpp"
#include "palpate/loop/collider.hpp"
#include "palpate/loop/execution.hpp"
#include "palpate/loop/live_objects.hpp"
#include "palpate/loop/ring.hpp"
#include "palpate/loop/soft_threads.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/types/arms.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::loop {

/// Throws std::invalid_argument naming a value that is not allowed. Not to be called from the cycle.
void check(const Controls& controls);

/// Mailboxes and queues between the loop and other threads.
class Front {
 public:
  /// contact: contact stage of the cycle, which must outlive the front. rate: of the cycle [Hz]. guidance: options of
  /// the stage for its fixtures. Throws std::invalid_argument if the scene is null or the contact method cannot handle
  /// it.
  Front(contact::Tool& contact, std::shared_ptr<const scene::Snapshot> scene, double rate,
        const guidance::Options& guidance);
  Front(const Front&) = delete;
  Front& operator=(const Front&) = delete;

  // For other threads, at any time; the loop takes new values at its next tick. The setters throw
  // std::invalid_argument.
  [[nodiscard]] Controls controls() const;
  void set_controls(const Controls& controls);
  /// Replaces the scene. Contact goes on if the number, names and surfaces of its objects stay the same.
  void set_scene(std::shared_ptr<const scene::Snapshot> scene);
  /// Sets the poses that the live objects of the newest scene shall reach.
  void set_live(LiveTargets targets);
  /// Replaces all fixtures of guidance at once, without a force step.
  void set_fixtures(std::shared_ptr<const guidance::FixtureList> fixtures);
  /// Gives the loop a motion of the follower to execute, in place of the one before, with the first order about it.
  /// Returns the number of the motion.
  std::uint64_t execute(PlannedMotion motion, ExecutionOrder order);
  /// Replaces the order; that of another motion has no effect.
  void set_order(const ExecutionOrder& order);
  /// The newest tick.
  [[nodiscard]] Tick latest();
  /// Vertices of a soft object of the newest scene, as deformed at most 16 ms ago: 3 per vertex of its mesh, in O [m].
  /// Throws std::invalid_argument if the object does not exist or is not soft.
  [[nodiscard]] std::vector<double> soft_vertices(std::size_t object);
  /// Moves at most n of the ticks since the last drain into rows. Returns their number.
  std::size_t drain(std::size_t n, Tick* rows);
  /// Number of ticks in the queue.
  [[nodiscard]] std::size_t waiting() const noexcept { return ring_.size(); }
  /// Number of ticks lost because the queue was full.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return ring_.dropped(); }

  /// Allocates the queue that keep() fills; to be called before a loop starts in real time. Lockstep does not use it.
  void open() { ring_.open(); }

  /// Starts the threads beside a loop in real time: of large soft bodies, and of collision queries that allocate memory
  /// (contact::Method::collide) at collision_rate [Hz].
  void start_threads(double collision_rate);
  void stop_threads();
  /// Runs one pending collision query on the newest scene in the calling thread.
  void collide();
  /// Message of the collider's first exception; empty if there was none.
  [[nodiscard]] std::string collider_fault() const { return collider_.fault(); }

  // For the thread of the loop, at every tick.
  [[nodiscard]] const Controls& take_controls() noexcept { return controls_in_.read(); }
  /// Switches scene() to the newest one that was set, and moves its live objects to the time t [s]. Returns true if the
  /// objects are others, so that contact must be reset.
  bool take_scene(double t) noexcept;
  /// Switches fixtures() to the newest ones that were set. Returns true if they are new.
  bool take_fixtures() noexcept { return fixtures_.update(); }
  /// Switches motion() to the newest one that was given; not to be called while the one before moves the follower.
  void take_motion() noexcept { motion_.update(); }
  /// The motion to execute; number 0 if there is none.
  [[nodiscard]] const PlannedMotion& motion() const noexcept { return motion_.current(); }
  [[nodiscard]] const ExecutionOrder& take_order() noexcept { return order_in_.read(); }
  [[nodiscard]] const scene::Snapshot& scene() const noexcept { return scene_.current().objects; }
  [[nodiscard]] const guidance::ActiveFixtures& fixtures() const noexcept { return fixtures_.current(); }
  /// Writes the live objects and tracked frames to a tick.
  void record(Tick& tick) const noexcept { live_.record(tick.t, tick); }
  /// Publishes a tick for latest().
  void show(const Tick& tick) noexcept { latest_.write(tick); }
  /// Adds a tick to the queue for drain().
  void keep(const Tick& tick) noexcept { ring_.push(tick); }

 private:
  contact::Tool& contact_;
  mutable std::mutex callers_;  ///< serialises the calls of other threads; the loop never locks it
  Controls controls_;
  std::shared_ptr<const scene::Snapshot> newest_scene_;  ///< last scene that was set, for the collider
  std::uint64_t newest_epoch_ = 0;                       ///< its RenderedScene::epoch
  Mailbox<Controls> controls_in_;
  Mailbox<Tick> latest_;
  Mailbox<LiveTargets> targets_in_;
  Handover<RenderedScene> scene_;
  scene::Snapshot newest_rendered_;  ///< copy of the newest scene that was handed over, for its soft bodies
  guidance::Options guidance_;
  double dt_;                               ///< period of the cycle [s]
  std::shared_ptr<guidance::Stage> stage_;  ///< made for the first fixture, and kept
  Handover<const guidance::ActiveFixtures> fixtures_;
  Handover<const PlannedMotion> motion_;
  std::uint64_t motions_ = 0;  ///< number of the newest motion
  Mailbox<ExecutionOrder> order_in_;
  LiveObjects live_;         ///< used by the loop only
  std::uint64_t epoch_ = 0;  ///< epoch of scene(), used by the loop only
  Ring<Tick> ring_;
  Collider collider_;
  SoftThreads soft_threads_;
};

}  // namespace palpate::loop
