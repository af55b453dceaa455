// Runs a device's driver, a shared object with the functions of driver.h, and the haptic cycle in a real-time thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>

#include "palpate/loop/device_cycle.hpp"
#include "palpate/loop/driver.hpp"
#include "palpate/loop/realtime.hpp"

namespace palpate::loop {

/// Reads, steps and writes at the rate of the device. A driver that reports a failure ends the loop with zero force.
/// While it has no measurement the force is zero. If a call does not return within kStall, a second thread commands
/// zero force. The loop continues after both, and the force returns by a ramp after a pause.
class DriverThread {
 public:
  static constexpr std::int64_t kStall = 12'000'000;        ///< longest time of a call of the driver [ns]
  static constexpr std::int64_t kPatience = 1'000'000'000;  ///< time after which a call counts as hanging [ns]

  DriverThread(std::shared_ptr<Driver> driver, std::shared_ptr<DeviceCycle> cycle);
  ~DriverThread() { stop(); }
  DriverThread(const DriverThread&) = delete;
  DriverThread& operator=(const DriverThread&) = delete;

  /// A thread that hangs in the driver cannot start again: throws std::logic_error.
  void start();
  /// Ramps the force to zero and ends both threads. A thread that hangs in the driver is left behind.
  void stop() noexcept;
  [[nodiscard]] const RealTimeThread& thread() const noexcept;
  /// Why the loop ended by itself, or that the driver hangs; empty if neither.
  [[nodiscard]] std::string fault() const;
  /// Buttons of the newest measurement, as DeviceState::buttons.
  [[nodiscard]] std::uint32_t buttons() const noexcept;
  /// Number of calls for which the watchdog wrote zero force.
  [[nodiscard]] std::uint64_t stalls() const noexcept;

 private:
  struct Shared;  // what the threads use; outlives this object if a thread hangs
  std::shared_ptr<Shared> shared_;
  std::thread watchdog_;
};

}  // namespace palpate::loop
