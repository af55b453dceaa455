// The thread that takes what arrives at a node and calls back; the interpreter has no part in it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>

#include "rcl/node.hpp"

namespace palpate::ros {

struct SpinnerOptions {
  std::function<void()> in_thread;      ///< called first in the thread: its priority, its core
  std::function<std::int64_t()> after;  ///< called after each round: how long the next may wait, at most [ns]
};

/// Callbacks run here, one after the other. What they throw is told as a problem of the node.
/// Stop it before anything its callbacks use goes away.
class Spinner {
 public:
  explicit Spinner(Node& node, SpinnerOptions options = {});
  ~Spinner() { stop(); }
  Spinner(const Spinner&) = delete;
  Spinner& operator=(const Spinner&) = delete;
  void stop() noexcept;

 private:
  void spin() noexcept;
  /// One wait and what it brought. Answers whether to go on.
  bool round(rcl_wait_set_t& set, std::int64_t patience);

  Node& node_;
  SpinnerOptions options_;
  std::atomic<bool> running_{true};
  std::thread thread_;
};

}  // namespace palpate::ros
