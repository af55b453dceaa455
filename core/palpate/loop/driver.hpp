// What a thread of the core needs from the driver of a device.
#pragma once

#include <string>
#include <vector>

#include "palpate/loop/device_cycle.hpp"
#include "palpate/loop/driver.h"

namespace palpate::loop {

/// Result of one reading.
enum class Reading : int {
  measured,  ///< the state is new
  missing,   ///< there is no measurement now: the force must be zero until there is one
  failed,    ///< the device cannot be read any more
};

/// An opened device. read() and write() are called in turn by one thread; write() with zeros also by another one while
/// a call of the first does not return.
class Driver {
 public:
  Driver() = default;
  virtual ~Driver() = default;
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;

  [[nodiscard]] const palpate_driver_info& info() const noexcept { return info_; }
  /// Measures the device.
  virtual Reading read(DeviceState& state) noexcept = 0;
  /// Commands a wrench; the driver keeps its moment below moment_max. Returns false if the device cannot be commanded.
  virtual bool write(const Wrench& F) noexcept = 0;
  /// Why a call failed, in words; empty if the driver does not say.
  [[nodiscard]] virtual std::string why() const { return ""; }
  /// What has happened to the device since it was opened, in words: cause; mend.
  [[nodiscard]] virtual std::vector<std::string> notices() const { return {}; }

 protected:
  palpate_driver_info info_{};
};

}  // namespace palpate::loop
