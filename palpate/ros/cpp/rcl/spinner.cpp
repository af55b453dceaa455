#include "rcl/spinner.hpp"

#include <algorithm>
#include <chrono>

#include "rcl/status.hpp"

namespace palpate::ros {
namespace {

constexpr std::int64_t kMaxWaitNs = 100'000'000;  // longest wait [ns]; a guard condition can end it earlier

}  // namespace

Spinner::Spinner(Node& node, SpinnerOptions options)
    : node_(node), options_(std::move(options)), thread_([this] { spin(); }) {}

void Spinner::stop() noexcept {
  if (!thread_.joinable()) return;
  running_ = false;
  if (rcl_trigger_guard_condition(&node_.woken_) != RCL_RET_OK) rcl_reset_error();
  thread_.join();
}

template <class Does>
void Spinner::guarded(Does does) noexcept {
  try {
    const std::lock_guard<std::mutex> lock(mutex_);
    does();
  } catch (const std::exception& error) {
    node_.problem(std::string("a callback failed: ") + error.what());
  } catch (...) {
    node_.problem("a callback failed");
  }
}

void Spinner::arrived(Entity& entity) noexcept {
  guarded([&] {
    entity.take();
    if (options_.after) options_.after();  // the spinner's thread sets its timeout itself
  });
}

void Spinner::spin() noexcept {
  node_.raise_receivers();
  if (options_.in_thread) options_.in_thread();
  rcl_wait_set_t set = rcl_get_zero_initialized_wait_set();
  Status ready = status(rcl_wait_set_init(&set, 0, 1, 0, 0, 0, 0, node_.context_->get(), rcl_get_default_allocator()),
                        "wait for messages");
  if (!ready) return node_.problem(ready.problem);
  std::int64_t timeout_ns = kMaxWaitNs;
  while (running_ && round(set, timeout_ns)) {
    guarded([&] {
      if (options_.after) timeout_ns = std::clamp(options_.after(), std::int64_t{0}, kMaxWaitNs);
    });
  }
  {
    const auto lock = node_.interrupt();
    for (Entity* entity : node_.entities_) entity->set_receiver(nullptr);
  }
  if (rcl_wait_set_fini(&set) != RCL_RET_OK) rcl_reset_error();
}

bool Spinner::round(rcl_wait_set_t& set, std::int64_t timeout_ns) {
  while (node_.visitors_ > 0) std::this_thread::sleep_for(std::chrono::microseconds(20));
  const std::lock_guard<std::mutex> lock(node_.entities_mutex_);
  const auto waits = [this](Entity* entity) { return !options_.direct || !entity->set_receiver(this); };
  Count n;
  for (Entity* entity : node_.entities_)
    if (waits(entity)) entity->count(n);
  rcl_ret_t answer = rcl_wait_set_resize(&set, n.subscriptions, 1, 0, n.clients, n.services, n.events);
  if (answer == RCL_RET_OK) answer = rcl_wait_set_clear(&set);
  if (answer == RCL_RET_OK) answer = rcl_wait_set_add_guard_condition(&set, &node_.woken_, nullptr);
  for (Entity* entity : node_.entities_)
    if (answer == RCL_RET_OK && waits(entity)) answer = entity->watch(set);
  if (answer == RCL_RET_OK) answer = rcl_wait(&set, timeout_ns);
  if (answer == RCL_RET_TIMEOUT) {
    rcl_reset_error();
    return true;
  }
  if (const Status waited = status(answer, "wait for messages"); !waited) {
    node_.problem(waited.problem);
    return false;
  }
  for (Entity* entity : node_.entities_)
    if (waits(entity)) guarded([&] { entity->work(set); });
  return true;
}

}  // namespace palpate::ros
