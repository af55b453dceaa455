// Something a spinner waits for: a subscription, a service, a client, an event.
#pragma once

#include <rcl/wait.h>

#include <cstddef>

namespace palpate::ros {

/// How many of each kind a wait set must hold.
struct Count {
  std::size_t subscriptions = 0, clients = 0, services = 0, events = 0;
};

class Entity {
 public:
  Entity() = default;
  virtual ~Entity() = default;
  Entity(const Entity&) = delete;
  Entity& operator=(const Entity&) = delete;

  virtual void count(Count& count) const noexcept = 0;
  /// Adds itself to the set; remembers its place there.
  virtual rcl_ret_t watch(rcl_wait_set_t& set) noexcept = 0;
  /// Takes what has come, if anything has, and calls back. In the spinner's thread.
  virtual void work(const rcl_wait_set_t& set) = 0;
};

}  // namespace palpate::ros
