// A thread in parallel to the loop that runs collision queries which allocate memory (contact::Method::collide).
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

namespace palpate::loop {

/// Runs a function periodically in a thread of its own and keeps its first exception.
class Collider {
 public:
  ~Collider() { stop(); }
  Collider() = default;
  Collider(const Collider&) = delete;
  Collider& operator=(const Collider&) = delete;

  /// Calls collide() repeatedly with a pause in between. An exception is kept for fault() and does not end the thread.
  void start(std::function<void()> collide, std::chrono::microseconds pause);
  /// Ends the thread and waits for it.
  void stop();
  /// Message of the first exception; empty if none was thrown. From any thread.
  [[nodiscard]] std::string fault() const;

 private:
  std::thread thread_;
  std::atomic<bool> stop_{false};
  mutable std::mutex mutex_;
  std::string fault_;
};

}  // namespace palpate::loop
