// Something a spinner waits for: a subscription, a service, a client, an event.
#pragma once

#include <rcl/error_handling.h>
#include <rcl/event_callback.h>
#include <rcl/wait.h>

#include <atomic>
#include <cstddef>

namespace palpate::ros {

/// How many of each kind a wait set must hold.
struct Count {
  std::size_t subscriptions = 0, clients = 0, services = 0, events = 0;
};

class Entity;

/// Takes what has come to an entity, in the thread in which the middleware brings it.
class Receiver {
 public:
  virtual ~Receiver() = default;
  virtual void arrived(Entity& entity) noexcept = 0;
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

  /// From now on everything that comes is told to the receiver as it comes, and nobody has to wait for it; nullptr: no
  /// longer, and no call is under way any more. Answers whether this entity and the middleware can.
  virtual bool tell(Receiver* receiver) noexcept {
    static_cast<void>(receiver);
    return false;
  }
  /// Takes what has come and calls back.
  virtual void take() {}

 protected:
  /// The same for an entity that rcl tells by a callback: `set(call, self)` sets it, or takes it away.
  template <class Set>
  bool tell_by(Receiver* receiver, Set set) noexcept {
    if (receiver_ == receiver) return receiver != nullptr;
    if (receiver) receiver_ = receiver;
    const auto arrived = [](const void* self, std::size_t) {
      auto* entity = static_cast<Entity*>(const_cast<void*>(self));
      entity->receiver_.load()->arrived(*entity);
    };
    const rcl_event_callback_t call = receiver ? static_cast<rcl_event_callback_t>(arrived) : nullptr;
    const bool done = set(call, static_cast<const Entity*>(this)) == RCL_RET_OK;
    if (!done) rcl_reset_error();
    if (!done || !receiver) receiver_ = nullptr;
    return done && receiver;
  }

 private:
  std::atomic<Receiver*> receiver_{nullptr};
};

}  // namespace palpate::ros
