// A thread that wakes at absolute deadlines, and says how well it did.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "palpate/loop/histogram.hpp"

namespace palpate::loop {

struct RealTimeOptions {
  bool allow_priority = true;  ///< SCHED_FIFO and locked memory, where the system lets us
  bool allow_affinity = true;  ///< one core for the loop alone, where there is more than one
  int priority = 80;           ///< of SCHED_FIFO
  double spin_us = 50.0;       ///< the last stretch before a deadline is awaited awake [us]; at most half a period
};

/// What the body of a tick is told.
struct Wake {
  std::int64_t lateness_ns = 0;  ///< start of the tick after its deadline
  std::int64_t missed = 0;       ///< deadlines that passed unused since the last tick
  bool stopping = false;         ///< somebody wants an end: finish safely, then answer false
};

/// Counts of a real-time thread, over all its starts.
struct Punctuality {
  Histogram lateness, slack;  ///< slack: from the end of a tick to the next deadline, 0 when passed
  std::atomic<std::uint64_t> ticks{0}, missed{0};
};

/// Asks the system for what a loop wants, for the calling thread: everything is asked for, nothing is needed. Answers
/// what was granted and what refused, in words.
std::string schedule(const RealTimeOptions& options);

class RealTimeThread {
 public:
  explicit RealTimeThread(RealTimeOptions options) : options_(options) {}
  ~RealTimeThread() { stop(); }
  RealTimeThread(const RealTimeThread&) = delete;
  RealTimeThread& operator=(const RealTimeThread&) = delete;

  /// Calls body(wake) at `rate` until it answers false. The body must not throw.
  void start(double rate, std::function<bool(const Wake&)> body);
  /// Asks the body to finish and waits for it.
  void stop();
  [[nodiscard]] bool running() const noexcept { return running_.load(std::memory_order_acquire); }
  [[nodiscard]] const Punctuality& punctuality() const noexcept { return punctuality_; }
  /// What the system granted, in words; "not started" before.
  [[nodiscard]] const std::string& scheduler() const noexcept { return scheduler_; }

 private:
  void loop(std::int64_t period_ns, const std::function<bool(const Wake&)>& body) noexcept;

  RealTimeOptions options_;
  std::thread thread_;
  std::atomic<bool> stop_{false}, running_{false};
  std::string scheduler_ = "not started";
  Punctuality punctuality_;
};

/// A loop that does nothing but keep time: what the machine itself can do, beside which a real loop is judged.
class BareLoop {
 public:
  explicit BareLoop(double rate, RealTimeOptions options = {}) : rate_(rate), thread_(options) {}
  void start() {
    thread_.start(rate_, [](const Wake& wake) { return !wake.stopping; });
  }
  void stop() { thread_.stop(); }
  [[nodiscard]] const RealTimeThread& thread() const noexcept { return thread_; }

 private:
  double rate_;
  RealTimeThread thread_;
};

/// Nanoseconds of the monotonic clock.
[[nodiscard]] std::int64_t now_ns() noexcept;

}  // namespace palpate::loop
