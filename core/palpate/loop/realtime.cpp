#include "palpate/loop/realtime.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <future>
#include <stdexcept>

namespace palpate::loop {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

std::atomic<int> threads{0};  // that need the memory locked

void sleep_until(std::int64_t t) noexcept {
  const timespec deadline{.tv_sec = t / kSecond, .tv_nsec = t % kSecond};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, nullptr) == EINTR) {
  }
}

}  // namespace

std::int64_t now_ns() noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

std::string schedule(const RealTimeOptions& options) {
  prctl(PR_SET_TIMERSLACK, 1UL);  // [ns] of this thread; the default of 50 us would make it late
  std::string words = "normal scheduling";
  if (options.allow_priority) {
    const sched_param param{.sched_priority = options.priority};
    // Threads and processes that this thread begins have normal scheduling: senders of Fast DDS, which wait for others
    // without sleeping, would stop the whole machine at this priority.
    const int error = sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &param) == 0 ? 0 : errno;
    words = error == 0 ? "SCHED_FIFO " + std::to_string(options.priority)
                       : std::string("normal scheduling (SCHED_FIFO refused: ") + std::strerror(error) + ")";
    if (mlockall(MCL_CURRENT) == 0) {
      words += ", memory locked";
    } else {
      words += std::string(", memory not locked (") + std::strerror(errno) + ")";
    }
  } else {
    const sched_param normal{.sched_priority = 0};
    sched_setscheduler(0, SCHED_OTHER, &normal);
  }
  if (options.allow_affinity) {
    cpu_set_t allowed;
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof(allowed), &allowed);
    int core = CPU_SETSIZE - 1;
    while (core > 0 && !CPU_ISSET(core, &allowed)) {
      --core;
    }
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    if (CPU_COUNT(&allowed) > 1) {
      const int error = pthread_setaffinity_np(pthread_self(), sizeof(one), &one);
      words += error == 0 ? ", core " + std::to_string(core) : std::string(", any core (") + std::strerror(error) + ")";
    }
  }
  return words;
}

void RealTimeThread::start(double rate, std::function<bool(const Wake&)> body) {
  if (thread_.joinable()) {
    throw std::logic_error("the real-time loop runs already: stop() it first");
  }
  const auto period_ns = static_cast<std::int64_t>(std::llround(1e9 / rate));
  std::promise<std::string> granted;
  std::future<std::string> words = granted.get_future();
  stop_ = false;
  running_ = true;
  thread_ = std::thread([this, period_ns, body = std::move(body), granted = std::move(granted)]() mutable {
    granted.set_value(schedule(options_));
    ++threads;
    loop(period_ns, body);
    if (--threads == 0) munlockall();
    running_.store(false, std::memory_order_release);
  });
  scheduler_ = words.get();
}

void RealTimeThread::stop() {
  stop_ = true;
  if (thread_.joinable()) {
    thread_.join();
  }
}

// Waits for absolute deadlines, so that errors do not accumulate. Missed deadlines are counted and skipped.
void RealTimeThread::loop(std::int64_t period_ns, const std::function<bool(const Wake&)>& body) noexcept {
  const auto spin_ns = std::min(static_cast<std::int64_t>(options_.spin_us * 1e3), period_ns / 2);
  Punctuality& p = punctuality_;
  Wake wake;
  std::int64_t deadline = now_ns() + period_ns;
  do {
    sleep_until(deadline - spin_ns);
    std::int64_t now = now_ns();
    while (now < deadline) {
      now = now_ns();
    }
    wake.lateness_ns = now - deadline;
    wake.missed = wake.lateness_ns / period_ns;
    deadline += wake.missed * period_ns;
    wake.stopping = stop_.load(std::memory_order_relaxed);
    p.lateness.add(wake.lateness_ns);
    p.ticks.fetch_add(1, std::memory_order_relaxed);
    p.missed.fetch_add(static_cast<std::uint64_t>(wake.missed), std::memory_order_relaxed);
    if (!body(wake)) {
      break;
    }
    deadline += period_ns;
    p.slack.add(deadline - now_ns());
  } while (true);
}

}  // namespace palpate::loop
