// Takes what arrives at a node and calls back, in a thread of its own or in the middleware's; the interpreter has no
// part in it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>

#include "rcl/node.hpp"

namespace palpate::ros {

struct SpinnerOptions {
  std::function<void()> in_thread;      ///< called first in the thread: its priority, its core
  std::function<std::int64_t()> after;  ///< called after each round: how long the next may wait, at most [ns]
  /// Messages are taken in the thread in which the middleware brings them, one at a time: one change of threads less on
  /// their way (20 to 30 us). Here is waited for all else, and for the time of `after`, which is called after each.
  bool direct = false;
};

/// Callbacks run here, one after the other. What they throw is told as a problem of the node.
/// Stop it before anything its callbacks use goes away.
class Spinner final : Receiver {
 public:
  explicit Spinner(Node& node, SpinnerOptions options = {});
  ~Spinner() override { stop(); }
  Spinner(const Spinner&) = delete;
  Spinner& operator=(const Spinner&) = delete;
  void stop() noexcept;

 private:
  void spin() noexcept;
  /// One wait and what it brought. Answers whether to go on.
  bool round(rcl_wait_set_t& set, std::int64_t patience);
  void arrived(Entity& entity) noexcept override;
  /// `does`, one at a time, and what it throws told.
  template <class Does>
  void guarded(Does does) noexcept;

  Node& node_;
  SpinnerOptions options_;
  std::mutex mutex_;  // of the callbacks
  std::atomic<bool> running_{true};
  std::thread thread_;
};

}  // namespace palpate::ros
