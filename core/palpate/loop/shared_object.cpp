#include "palpate/loop/shared_object.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace palpate::loop {
namespace {

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
  if (!within(info.resolution, 0.0, 0.01)) {
    refuse("resolution = " + std::to_string(info.resolution) + " m must be 0 to 0.01 m");
  }
  if (!within(info.mass, 0.0, 100.0)) refuse("mass = " + std::to_string(info.mass) + " kg must be 0 to 100 kg");
  if (!within(info.delay, 0.0, 0.1)) refuse("delay = " + std::to_string(info.delay) + " s must be 0 to 0.1 s");
  if (!within(info.friction, 0.0, 100.0)) {
    refuse("friction = " + std::to_string(info.friction) + " N must be 0 to 100 N");
  }
  if (!within(info.damping, 0.0, 1000.0)) {
    refuse("damping = " + std::to_string(info.damping) + " N s/m must be 0 to 1000 N s/m");
  }
}

}  // namespace

SharedObject::SharedObject(const std::string& file, const std::string& argument) {
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

SharedObject::~SharedObject() {
  SharedObject::write({});
  unload();
}

void SharedObject::unload() noexcept {
  if (device_ != nullptr) close_(device_);
  dlclose(library_);
}

Reading SharedObject::read(DeviceState& state) noexcept {
  palpate_driver_state s{};
  std::fill_n(s.X_LH, 16, std::numeric_limits<double>::quiet_NaN());  // a driver that fills in nothing is noticed
  if (read_(device_, &s) != 0) return Reading::failed;
  std::copy_n(s.X_LH, 16, state.X_LH.begin());
  if (s.has_velocity != 0) {
    std::copy_n(s.V_LH, 6, state.V_LH.emplace().begin());
  } else {
    state.V_LH.reset();
  }
  state.gripper = s.gripper;
  state.buttons = s.buttons;
  state.clutch = (s.buttons & PALPATE_BUTTON_CLUTCH) != 0;
  return Reading::measured;
}

bool SharedObject::write(const Wrench& F) noexcept {
  const double moment = F.t.norm(), share = moment > info_.moment_max ? info_.moment_max / moment : 1.0;
  const double wrench[6] = {F.f.x(), F.f.y(), F.f.z(), share * F.t.x(), share * F.t.y(), share * F.t.z()};
  return write_(device_, wrench) == 0;
}

}  // namespace palpate::loop
