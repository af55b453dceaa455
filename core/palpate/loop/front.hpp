// The side of a running loop that people see: they steer it and read its ticks, from any thread, and it waits for
// nobody.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "palpate/contact/tool.hpp"
#include "palpate/guidance/fixture.hpp"
#include "palpate/loop/collider.hpp"
#include "palpate/loop/ring.hpp"
#include "palpate/loop/tick.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/types/arms.hpp"
#include "palpate/types/mailbox.hpp"

namespace palpate::loop {

/// Throws std::invalid_argument naming a value that is not allowed. Not for the cycle.
void check(const Controls& controls);

class Front {
 public:
  /// contact: of the cycle; it outlives the front. rate: of the cycle [Hz]. Throws std::invalid_argument when there is
  /// no scene, or one that the contact method cannot feel.
  Front(contact::Tool& contact, std::shared_ptr<const scene::Snapshot> scene, double rate);
  Front(const Front&) = delete;
  Front& operator=(const Front&) = delete;

  // From any thread, at any time; the loop takes the new values at its next tick.
  [[nodiscard]] Controls controls() const;
  void set_controls(const Controls& controls);
  void set_scene(std::shared_ptr<const scene::Snapshot> scene);
  /// Swaps all fixtures of guidance at once. No force that the hand feels jumps.
  void set_fixtures(std::shared_ptr<const guidance::Fixtures> fixtures);
  /// The newest tick.
  [[nodiscard]] Tick latest();
  /// Ticks since the last drain: at most n of them, into rows. Returns their number.
  std::size_t drain(std::size_t n, Tick* rows);
  [[nodiscard]] std::size_t waiting() const noexcept { return ring_.size(); }
  /// Ticks that were lost because nobody drained them.
  [[nodiscard]] std::uint64_t dropped() const noexcept { return ring_.dropped(); }

  /// Takes the memory of the queue that `keep` fills, once; before a loop starts in real time. Lockstep needs none.
  void open() { ring_.open(); }

  // For contact methods whose geometry allocates (contact::Method::collide). collision_rate [Hz].
  void start_collider(double collision_rate);
  void stop_collider();
  /// Answers one collision request of the newest scene, in the calling thread.
  void collide();
  /// First exception of the collider, in words; empty when there was none.
  [[nodiscard]] std::string collider_fault() const { return collider_.fault(); }

  // The loop's side: one thread, at every tick.
  [[nodiscard]] const Controls& take_controls() noexcept { return controls_in_.read(); }
  /// True when there is a new scene, or there are new fixtures.
  bool take_scene() noexcept { return scene_.take(); }
  bool take_fixtures() noexcept { return fixtures_.take(); }
  [[nodiscard]] const scene::Snapshot& scene() const noexcept { return scene_.current(); }
  [[nodiscard]] const guidance::Fixtures& fixtures() const noexcept { return fixtures_.current(); }
  /// Makes a tick the newest.
  void show(const Tick& tick) noexcept { latest_.write(tick); }
  /// Adds a tick to those that wait for a drain.
  void keep(const Tick& tick) noexcept { ring_.push(tick); }

 private:
  contact::Tool& contact_;
  mutable std::mutex people_;  ///< between callers who look and steer; the loop never takes it
  Controls controls_;
  std::shared_ptr<const scene::Snapshot> newest_scene_;  ///< as given last; for the collider
  Mailbox<Controls> controls_in_;
  Mailbox<Tick> latest_;
  Handover<scene::Snapshot> scene_;
  Handover<guidance::Fixtures> fixtures_;
  Ring<Tick> ring_;
  Collider collider_;
};

}  // namespace palpate::loop
