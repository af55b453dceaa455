// Takes the messages that arrive at a node and runs the callbacks, in its own thread or in the middleware's, without
// the Python interpreter.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

#include "rcl/node.hpp"

namespace palpate::ros {

struct SpinnerOptions {
  std::function<void()> in_thread;      ///< called first in the thread: sets its priority and core
  std::function<std::int64_t()> after;  ///< called after each round; returns the timeout of the next wait [ns]
  /// Take messages one at a time in the middleware's receiving thread, which saves one change of threads (20 to 30 us).
  /// `after` is called after each message. The spinner's thread waits for entities without arrival callback.
  bool direct = false;
};

/// Runs the callbacks one at a time, and reports their exceptions as problems of the node.
/// Stop the spinner before destroying any object that its callbacks use.
class Spinner final : Receiver {
 public:
  explicit Spinner(Node& node, SpinnerOptions options = {});
  ~Spinner() override { stop(); }
  Spinner(const Spinner&) = delete;
  Spinner& operator=(const Spinner&) = delete;
  void stop() noexcept;

 private:
  void spin() noexcept;
  /// Waits once, for at most `timeout_ns` [ns], and handles the messages. Returns false if waiting fails.
  bool round(rcl_wait_set_t& set, std::int64_t timeout_ns);
  void arrived(Entity& entity) noexcept override;
  /// Runs `does` under the mutex and reports its exceptions to the node.
  template <class Does>
  void guarded(Does does) noexcept;

  Node& node_;
  SpinnerOptions options_;
  std::mutex mutex_;  // held while a callback runs
  std::atomic<bool> running_{true};
  std::thread thread_;
};

}  // namespace palpate::ros
