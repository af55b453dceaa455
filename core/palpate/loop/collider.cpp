#include "palpate/loop/collider.hpp"

#include <exception>
#include <utility>

namespace palpate::loop {

void Collider::start(std::function<void()> collide, std::chrono::microseconds pause) {
  stop_ = false;
  thread_ = std::thread([this, collide = std::move(collide), pause] {
    while (!stop_.load(std::memory_order_relaxed)) {
      try {
        collide();
      } catch (const std::exception& error) {
        const std::lock_guard lock(mutex_);
        if (fault_.empty()) {
          fault_ = error.what();
        }
      }
      std::this_thread::sleep_for(pause);
    }
  });
}

void Collider::stop() {
  stop_ = true;
  if (thread_.joinable()) {
    thread_.join();
  }
}

std::string Collider::fault() const {
  const std::lock_guard lock(mutex_);
  return fault_;
}

}  // namespace palpate::loop
