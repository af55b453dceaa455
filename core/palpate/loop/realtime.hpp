// A thread that wakes at absolute deadlines and records its lateness.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "palpate/loop/histogram.hpp"

namespace palpate::loop {

/// Options of a real-time thread.
struct RealTimeOptions {
  bool allow_priority = true;  ///< request SCHED_FIFO and locked memory
  bool allow_affinity = true;  ///< pin the thread to one core if there are several
  int priority = 80;           ///< SCHED_FIFO priority
  double spin_us = 50.0;       ///< busy waiting before each deadline [us]; at most half a period
};

/// Input of the body of a tick.
struct Wake {
  std::int64_t lateness_ns = 0;  ///< time from the deadline to the start of the tick [ns]
  std::int64_t missed = 0;       ///< number of deadlines missed since the last tick
  bool stopping = false;         ///< a stop is requested: the body finishes safely, then returns false
};

/// Statistics of a real-time thread, over all its starts.
struct Punctuality {
  Histogram lateness, slack;  ///< slack: time from the end of a tick to the next deadline, 0 if that has passed
  std::atomic<std::uint64_t> ticks{0}, missed{0};  ///< number of ticks and of missed deadlines
};

/// Requests priority, locked memory and a core for the calling thread. A refusal is not an error. Returns a text that
/// says what was granted and what was refused.
std::string schedule(const RealTimeOptions& options);

/// A thread that runs a function at a fixed rate.
class RealTimeThread {
 public:
  explicit RealTimeThread(RealTimeOptions options) : options_(options) {}
  ~RealTimeThread() { stop(); }
  RealTimeThread(const RealTimeThread&) = delete;
  RealTimeThread& operator=(const RealTimeThread&) = delete;

  /// Calls body(wake) at `rate` [Hz] until it returns false. The body must not throw. Throws std::logic_error if the
  /// thread runs already.
  void start(double rate, std::function<bool(const Wake&)> body);
  /// Requests a stop (Wake::stopping) without waiting.
  void request_stop() noexcept { stop_ = true; }
  /// Requests a stop and waits until the body has finished.
  void stop();
  [[nodiscard]] bool running() const noexcept { return running_.load(std::memory_order_acquire); }
  [[nodiscard]] const Punctuality& punctuality() const noexcept { return punctuality_; }
  /// The text of schedule(); "not started" before the first start.
  [[nodiscard]] const std::string& scheduler() const noexcept { return scheduler_; }

 private:
  void loop(std::int64_t period_ns, const std::function<bool(const Wake&)>& body) noexcept;

  RealTimeOptions options_;
  std::thread thread_;
  std::atomic<bool> stop_{false}, running_{false};
  std::string scheduler_ = "not started";
  Punctuality punctuality_;
};

/// A loop with an empty body. It measures the lateness of the machine itself, as a reference for a real loop.
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

/// Time of the monotonic clock [ns].
[[nodiscard]] std::int64_t now_ns() noexcept;

}  // namespace palpate::loop
