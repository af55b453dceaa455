#include "palpate/loop/driver_thread.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>
#include <utility>

namespace palpate::loop {
namespace {

constexpr auto kWatchPeriod = std::chrono::milliseconds(2);
constexpr auto kLongestEnd = std::chrono::milliseconds(500);  // wait for a thread that may hang in the driver

template <class Function>
Function* symbol(void* library, const char* name) {
  auto* found = reinterpret_cast<Function*>(dlsym(library, name));
  if (found == nullptr) throw std::invalid_argument(std::string("it has no function ") + name + " (see driver.h)");
  return found;
}

void check_info(const palpate_driver_info& info) {
  const auto within = [](double x, double low, double high) { return x >= low && x <= high; };
  const auto refuse = [](const std::string& words) { throw std::invalid_argument(words); };
  if (info.abi != PALPATE_DRIVER_ABI) {
    refuse("it is compiled for version " + std::to_string(info.abi) + " of driver.h, this is version " +
           std::to_string(PALPATE_DRIVER_ABI) + ": compile it again");
  }
  if (!within(info.rate, 50.0, 10000.0)) refuse("rate = " + std::to_string(info.rate) + " Hz must be 50 to 10000 Hz");
  if (!within(info.force_max, 0.0, 100.0)) {
    refuse("force_max = " + std::to_string(info.force_max) + " N must be 0 to 100 N");
  }
  if (!within(info.moment_max, 0.0, 10.0)) {
    refuse("moment_max = " + std::to_string(info.moment_max) + " N m must be 0 to 10 N m");
  }
}

}  // namespace

Driver::Driver(const std::string& file, const std::string& argument) {
  library_ = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library_ == nullptr) throw std::invalid_argument(dlerror());
  try {
    const auto open = symbol<decltype(palpate_driver_open)>(library_, "palpate_driver_open");
    read_ = symbol<decltype(palpate_driver_read)>(library_, "palpate_driver_read");
    write_ = symbol<decltype(palpate_driver_write)>(library_, "palpate_driver_write");
    close_ = symbol<decltype(palpate_driver_close)>(library_, "palpate_driver_close");
    char why[256] = "";
    device_ = open(argument.c_str(), &info_, why, sizeof(why));
    why[sizeof(why) - 1] = '\0';
    if (device_ == nullptr) throw std::invalid_argument(std::string("the device cannot be opened: ") + why);
    info_.name[sizeof(info_.name) - 1] = '\0';
    check_info(info_);
  } catch (...) {
    unload();
    throw;
  }
}

Driver::~Driver() {
  write({});
  unload();
}

void Driver::unload() noexcept {
  if (device_ != nullptr) close_(device_);
  dlclose(library_);
}

bool Driver::read(DeviceState& state) noexcept {
  palpate_driver_state s{};
  std::fill_n(s.X_LH, 16, std::numeric_limits<double>::quiet_NaN());  // a driver that fills in nothing is noticed
  if (read_(device_, &s) != 0) return false;
  std::copy_n(s.X_LH, 16, state.X_LH.begin());
  if (s.has_velocity != 0) {
    std::copy_n(s.V_LH, 6, state.V_LH.emplace().begin());
  } else {
    state.V_LH.reset();
  }
  state.gripper = s.gripper;
  state.clutch = (s.buttons & 1u) != 0;
  return true;
}

bool Driver::write(const Wrench& F) noexcept {
  const double moment = F.t.norm(), share = moment > info_.moment_max ? info_.moment_max / moment : 1.0;
  const double wrench[6] = {F.f.x(), F.f.y(), F.f.z(), share * F.t.x(), share * F.t.y(), share * F.t.z()};
  return write_(device_, wrench) == 0;
}

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
    const bool read = driver->read(state);
    state.t = 1e-9 * static_cast<double>(now_ns());
    enter(none);
    if (!read) return fail(reading);
    // After a stall the watchdog has commanded zero: the cycle is told, so that the force returns by a ramp.
    const Wrench& F = silenced.exchange(false) ? cycle->report_failure() : cycle->step(state);
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
std::uint64_t DriverThread::stalls() const noexcept { return shared_->stalls.load(std::memory_order_relaxed); }

std::string DriverThread::fault() const {
  const auto name = [](int call) { return std::string(call == Shared::reading ? "read()" : "write()"); };
  if (const int call = shared_->failed; call != Shared::none) return name(call) + " reported a failure";
  if (shared_->spent() > kPatience) return name(shared_->call) + " did not return within 1 s";
  return "";
}

}  // namespace palpate::loop
