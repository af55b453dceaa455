// Base class of everything that a spinner waits for: subscriptions, services, clients, events.
#pragma once

#include <rcl/error_handling.h>
#include <rcl/event_callback.h>
#include <rcl/wait.h>

#include <atomic>
#include <cstddef>

namespace palpate::ros {

/// Number of entities of each kind in a wait set.
struct Count {
  std::size_t subscriptions = 0, clients = 0, services = 0, events = 0;
};

class Entity;

/// Takes new messages of an entity, in the middleware's receiving thread.
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
  /// Adds the entity to the wait set and stores its index there.
  virtual rcl_ret_t watch(rcl_wait_set_t& set) noexcept = 0;
  /// Takes all new messages, if the wait set reports any, and calls back. Called in the spinner's thread.
  virtual void work(const rcl_wait_set_t& set) = 0;

  /// From now on calls the receiver at each arrival, so that the spinner need not wait for this entity. nullptr ends
  /// this; no call to the receiver is running any more when the function returns. Returns whether the entity and the
  /// middleware support it.
  virtual bool set_receiver(Receiver* receiver) noexcept {
    static_cast<void>(receiver);
    return false;
  }
  /// Takes all new messages and calls back.
  virtual void take() {}
  /// Number of matched publishers of a subscription, without a wait [-]; 0 for other entities, or if the query fails.
  [[nodiscard]] virtual std::size_t publishers() const noexcept { return 0; }

 protected:
  /// Implements set_receiver() for an entity with an rcl arrival callback: `set(call, self)` sets or removes the
  /// callback.
  template <class Set>
  bool set_receiver_by(Receiver* receiver, Set set) noexcept {
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
