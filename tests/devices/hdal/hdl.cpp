/* Stand-in for HDAL: a Falcon that moves 30 mm down (y) within 300 servo ticks after its first 300. The force of each
 * tick goes to the file of HDL_LOG; with HDL_FAIL it fails at tick 700. A device of the name `new` is not calibrated;
 * there is none `absent`. */
#include "hdl/hdl.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

namespace {
HDLServoOp* operation = nullptr;
void* context = nullptr;
std::thread servo;
std::atomic<bool> running{false};
std::atomic<int> tick{0};
bool calibrated = true;
double force[3];

void serve() {
  std::FILE* log = std::getenv("HDL_LOG") ? std::fopen(std::getenv("HDL_LOG"), "w") : nullptr;
  for (bool go = true; running && go; ++tick) {
    go = operation == nullptr || operation(context) == HDL_SERVOOP_CONTINUE;
    if (log != nullptr) std::fprintf(log, "%g %g %g\n", force[0], force[1], force[2]), std::fflush(log);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (log != nullptr) std::fclose(log);
}
}  // namespace

extern "C" {
HDLError hdlGetError() { return std::getenv("HDL_FAIL") != nullptr && tick > 700 ? 0x10 : HDL_NO_ERROR; }
HDLDeviceHandle hdlInitNamedDevice(const char* name, const char*) {
  calibrated = name == nullptr || std::strcmp(name, "new") != 0;
  return name != nullptr && std::strcmp(name, "absent") == 0 ? HDL_INVALID_HANDLE : 2;
}
void hdlStart() {}
void hdlStop() {
  running = false;
  if (servo.joinable()) servo.join();
}
unsigned int hdlGetState() { return calibrated ? 0u : HDAL_NOT_CALIBRATED; }
void hdlUninitDevice(HDLDeviceHandle) {}
void hdlMakeCurrent(HDLDeviceHandle) {}
void hdlDeviceWorkspace(double w[6]) {
  const double limits[6] = {-0.06, -0.06, -0.07, 0.06, 0.06, 0.04};
  std::memcpy(w, limits, sizeof limits);
}
void hdlSetToolForce(double F[3]) { std::memcpy(force, F, sizeof force); }
void hdlToolPosition(double p[3]) {
  p[0] = p[2] = 0.0, p[1] = -0.03 * std::fmin(1.0, std::fmax(0.0, tick / 300.0 - 1.0));
}
void hdlToolButtons(int* mask) { *mask = HDL_BUTTON_2 | HDL_BUTTON_4; }
HDLOpHandle hdlCreateServoOp(HDLServoOp op, void* param, bool) {
  operation = op, context = param, tick = 0, running = true;
  servo = std::thread(serve);
  return 1;
}
void hdlDestroyServoOp(HDLOpHandle) {}
}
