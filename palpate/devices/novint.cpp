/* Driver for the Falcon by Novint's HDAL, which must be installed (the SDK of Force Dimension drives it as well):
 *
 *     c++ -O2 -shared -fPIC -I FOLDER_OF_driver.h novint.cpp -o novint.so -lhdl
 *
 *     arms: {leader: {driver: ./novint.so}}                 # the default device, or novint.so:NAME of HDAL.INI
 *
 * HDAL calls a servo operation at 1 kHz (servo.h). It has metres; x is right, y up, z towards the user. The four
 * buttons of the grip in the order of HDAL's mask are clutch, gripper, camera and coagulation. Judged with a stand-in
 * of HDAL, not with a device. */
#include <hdl/hdl.h>

#include <cstdio>
#include <new>

#include "servo.h"

namespace {

struct Device {
  palpate_servo servo{};
  HDLDeviceHandle handle = HDL_INVALID_HANDLE;
  HDLOpHandle operation = HDL_INVALID_HANDLE;
};

palpate_driver_state state_of(const double position[3], int buttons) {
  palpate_driver_state s{};
  for (int i = 0; i < 4; ++i) s.X_LH[5 * i] = 1.0;
  for (int i = 0; i < 3; ++i) s.X_LH[4 * i + 3] = position[i];
  if (buttons & HDL_BUTTON_1) s.buttons |= PALPATE_BUTTON_CLUTCH;
  if (buttons & HDL_BUTTON_3) s.buttons |= PALPATE_BUTTON_CAMERA;
  if (buttons & HDL_BUTTON_4) s.buttons |= PALPATE_BUTTON_COAG;
  s.buttons |= (static_cast<unsigned>(buttons) & 15u) * PALPATE_BUTTON_OWN(0);
  s.gripper = (buttons & HDL_BUTTON_2) ? 0.0 : PALPATE_SERVO_OPENING;
  return s;
}

HDLServoOpExitCode servo(void* data) {
  auto* d = static_cast<Device*>(data);
  double position[3] = {0.0, 0.0, 0.0}, force[3] = {0.0, 0.0, 0.0};
  int buttons = 0;
  hdlMakeCurrent(d->handle);
  hdlToolPosition(position);
  hdlToolButtons(&buttons);
  if (hdlGetError() == HDL_NO_ERROR) {  // one of the force below is found in the next tick
    const palpate_driver_state state = state_of(position, buttons);
    if (palpate_servo_exchange(&d->servo, &state, force)) hdlSetToolForce(force);
    return HDL_SERVOOP_CONTINUE;
  }
  hdlSetToolForce(force);  // zero, and the position is not handed over
  d->servo.failed = 1;
  return HDL_SERVOOP_EXIT;
}

void* refuse(Device* d, char* why, size_t size, const char* words) {
  std::snprintf(why, size, "%s", words);
  delete d;
  return nullptr;
}

}  // namespace

extern "C" {

void* palpate_driver_open(const char* argument, palpate_driver_info* info, char* why, size_t size) {
  auto* d = new (std::nothrow) Device;
  if (d == nullptr) return nullptr;
  const char* none = nullptr;
  d->handle = hdlInitNamedDevice(argument[0] ? argument : none);
  if (d->handle == HDL_INVALID_HANDLE || hdlGetError() != HDL_NO_ERROR)
    return refuse(d, why, size, "HDAL finds no Falcon of this name: check power and cable, and HDAL.INI");
  hdlStart();
  hdlMakeCurrent(d->handle);
  if (hdlGetError() != HDL_NO_ERROR || (hdlGetState() & HDAL_NOT_CALIBRATED) != 0) {
    hdlStop();
    hdlUninitDevice(d->handle);
    return refuse(d, why, size, "the Falcon is not calibrated: pull its grip out and push it in once");
  }
  pthread_mutex_init(&d->servo.lock, nullptr);
  double limits[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
  hdlDeviceWorkspace(limits);
  info->abi = PALPATE_DRIVER_ABI;
  std::snprintf(info->name, sizeof info->name, "Falcon %s", argument);
  info->rate = 1000.0;
  info->force_max = 8.0;
  for (int i = 0; i < 3; ++i) info->workspace[i] = limits[3 + i] - limits[i];
  d->operation = hdlCreateServoOp(servo, d, false);
  palpate_servo_wait(&d->servo, 500);
  return d;
}

int palpate_driver_read(void* p, palpate_driver_state* state) {
  return palpate_servo_read(&static_cast<Device*>(p)->servo, state);
}

int palpate_driver_write(void* p, const double wrench[6]) {
  return palpate_servo_write(&static_cast<Device*>(p)->servo, wrench);
}

void palpate_driver_close(void* p) {
  auto* d = static_cast<Device*>(p);
  palpate_servo_wait(&d->servo, 25);
  hdlDestroyServoOp(d->operation);
  hdlStop();
  hdlUninitDevice(d->handle);
  pthread_mutex_destroy(&d->servo.lock);
  delete d;
}

}  // extern "C"
