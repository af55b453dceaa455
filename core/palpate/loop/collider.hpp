// The thread beside the loop that answers contact methods whose geometry allocates (contact::Method::collide).
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace palpate::loop {

class Collider {
 public:
  ~Collider() { stop(); }
  Collider() = default;
  Collider(const Collider&) = delete;
  Collider& operator=(const Collider&) = delete;

  /// Calls collide() again and again, `pause` apart. What it throws is kept for fault(); it goes on trying.
  void start(std::function<void()> collide, std::chrono::microseconds pause);
  void stop();
  /// The first thing that was thrown; empty when nothing was.
  [[nodiscard]] std::string fault() const;

 private:
  std::thread thread_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  std::string fault_;
};

}  // namespace palpate::loop
