// A driver in C: a shared object with the functions of driver.h.
#pragma once

#include <string>

#include "palpate/loop/driver.hpp"

namespace palpate::loop {

/// A loaded and opened driver.
class SharedObject final : public Driver {
 public:
  /// file: the shared object. Throws std::invalid_argument with the reason if it cannot be loaded or opened, or if its
  /// facts are invalid.
  SharedObject(const std::string& file, const std::string& argument);
  ~SharedObject() override;

  Reading read(DeviceState& state) noexcept override;
  bool write(const Wrench& F) noexcept override;

 private:
  void unload() noexcept;

  void* library_ = nullptr;
  void* device_ = nullptr;
  decltype(&palpate_driver_read) read_ = nullptr;
  decltype(&palpate_driver_write) write_ = nullptr;
  decltype(&palpate_driver_close) close_ = nullptr;
};

}  // namespace palpate::loop
