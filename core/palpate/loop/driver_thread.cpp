#include "palpate/loop/driver_thread.hpp"

#include <chrono>
#include <new>
#include <stdexcept>
#include <utility>

namespace palpate::loop {
namespace {

constexpr auto kWatchPeriod = std::chrono::milliseconds(2);
constexpr auto kLongestEnd = std::chrono::milliseconds(500);  // wait for a thread that may hang in the driver

}  // namespace

struct DriverThread::Shared {
  enum Call : int { none, reading, writing };
  Shared(std::shared_ptr<Driver> d, std::shared_ptr<DeviceCycle> c)
      : driver(std::move(d)), cycle(std::move(c)), thread(RealTimeOptions{.allow_affinity = false}) {}

  std::shared_ptr<Driver> driver;
  std::shared_ptr<DeviceCycle> cycle;
  DeviceState state;
  std::atomic<bool> silenced{false}, finished{true}, hung{false};
  std::atomic<int> call{none}, failed{none};
  std::atomic<std::int64_t> entered{0};  // time at which the present call began [ns]
  std::atomic<std::uint64_t> stalls{0};
  std::atomic<std::uint32_t> buttons{0};
  RealTimeThread thread;

  void enter(Call now) noexcept {
    entered.store(now_ns(), std::memory_order_relaxed);
    call.store(now, std::memory_order_release);
  }
  [[nodiscard]] std::int64_t spent() const noexcept {
    return call.load(std::memory_order_acquire) == none ? 0 : now_ns() - entered.load(std::memory_order_relaxed);
  }
  bool fail(Call at) noexcept {
    failed = at;
    cycle->report_failure();
    return end();
  }
  bool end() noexcept {
    call = none;
    driver->write({});
    finished = true;
    return false;
  }

  bool tick(const Wake& wake) noexcept {
    if (wake.stopping) cycle->allow_force(false);
    enter(reading);
    const Reading read = driver->read(state);
    state.t = 1e-9 * static_cast<double>(now_ns());
    enter(none);
    if (read == Reading::failed) return fail(reading);
    if (read == Reading::measured) buttons.store(state.buttons, std::memory_order_relaxed);
    // After a stall the watchdog has commanded zero: the cycle is told, so that the force returns by a ramp.
    const bool stalled = silenced.exchange(false) || read == Reading::missing;
    const Wrench& F = stalled ? cycle->report_failure() : cycle->step(state);
    if (wake.stopping && F.f.isZero(0.0) && F.t.isZero(0.0)) return end();
    enter(writing);
    const bool written = driver->write(F);
    enter(none);
    return written || fail(writing);
  }

  void watch() noexcept {
    while (!finished) {
      std::this_thread::sleep_for(kWatchPeriod);
      if (spent() > kStall && !silenced.exchange(true)) {
        driver->write({});
        stalls.fetch_add(1, std::memory_order_relaxed);
      }
    }
  }
};

DriverThread::DriverThread(std::shared_ptr<Driver> driver, std::shared_ptr<DeviceCycle> cycle)
    : shared_(std::make_shared<Shared>(std::move(driver), std::move(cycle))) {}

void DriverThread::start() {
  Shared& s = *shared_;
  if (s.hung) throw std::logic_error("the driver still hangs: end this process");
  if (!s.finished) return;
  stop();
  s.finished = s.silenced = false;
  s.failed = s.call = Shared::none;
  s.cycle->allow_force(true);
  s.thread.start(s.cycle->options().rate, [shared = shared_](const Wake& wake) { return shared->tick(wake); });
  watchdog_ = std::thread([shared = shared_] { shared->watch(); });
}

void DriverThread::stop() noexcept {
  Shared& s = *shared_;
  if (s.hung) return;
  s.thread.request_stop();
  const auto end = std::chrono::steady_clock::now() + kLongestEnd;
  while (!s.finished && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(kWatchPeriod);
  if (s.finished) {
    s.thread.stop();
    if (watchdog_.joinable()) watchdog_.join();
    return;
  }
  s.hung = true;
  if (watchdog_.joinable()) watchdog_.detach();
  static_cast<void>(new (std::nothrow) std::shared_ptr<Shared>(shared_));  // never freed: the hanging thread uses it
}

const RealTimeThread& DriverThread::thread() const noexcept { return shared_->thread; }
std::uint32_t DriverThread::buttons() const noexcept { return shared_->buttons.load(std::memory_order_relaxed); }
std::uint64_t DriverThread::stalls() const noexcept { return shared_->stalls.load(std::memory_order_relaxed); }

std::string DriverThread::fault() const {
  const auto name = [](int call) { return std::string(call == Shared::reading ? "read()" : "write()"); };
  if (const int call = shared_->failed; call != Shared::none) {
    const std::string why = shared_->driver->why();
    return why.empty() ? name(call) + " reported a failure" : why;
  }
  if (shared_->spent() > kPatience) return name(shared_->call) + " did not return within 1 s";
  return "";
}

}  // namespace palpate::loop
