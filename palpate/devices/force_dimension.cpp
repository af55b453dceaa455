/* Driver for devices of Force Dimension and the Falcon by the vendor's SDK, which must be installed, without Python:
 *
 *     c++ -O2 -shared -fPIC -I FOLDER_OF_driver.h -I SDK/include force_dimension.cpp -o force_dimension.so -ldhd
 *
 *     arms: {leader: {driver: ./force_dimension.so}}        # the first device, or force_dimension.so:SERIAL
 *
 * x is towards the user, y right, z up. Buttons 0, 1 and 2 are clutch, camera pedal and coagulation; 3 closes the jaws
 * of a device without a gripper. A device whose wrist has no motors gets no moment. Judged with a stand-in of the SDK,
 * not with a device. */
#include <dhdc.h>

#include <cerrno>
#include <climits>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "driver.h"

namespace {

constexpr double kOpening = 0.5;    // [rad] angle of the gripper of a device without one
constexpr double kForceMax = 8.0;   // [N] of the weakest device, a Falcon
constexpr double kMomentMax = 0.1;  // [N m] of a wrist with motors

struct Device {
  char id;
  bool wrist, gripper;
};

void* refuse(char* why, size_t size, const char* words) {
  std::snprintf(why, size, "%s: %s", words, dhdErrorGetLastStr());
  return nullptr;
}

unsigned acts(unsigned mask) {
  return ((mask & 1u) ? PALPATE_BUTTON_CLUTCH : 0u) | ((mask & 2u) ? PALPATE_BUTTON_CAMERA : 0u) |
         ((mask & 4u) ? PALPATE_BUTTON_COAG : 0u);
}

}  // namespace

extern "C" {

void* palpate_driver_open(const char* argument, palpate_driver_info* info, char* why, size_t size) {
  char* end = nullptr;
  errno = 0;
  const long serial = std::strtol(argument, &end, 10);
  if (*end != '\0' || errno != 0 || serial < 0 || serial > INT_MAX) {
    std::snprintf(why, size, "%s is no serial number of a device of Force Dimension: give a number", argument);
    return nullptr;
  }
  const int id = argument[0] ? dhdOpenSerial(static_cast<int>(serial)) : dhdOpen();
  if (id < 0) return refuse(why, size, "no device of Force Dimension opens: check power, cable and udev rules");
  const char ID = static_cast<char>(id);
  auto* d = new (std::nothrow) Device{ID, dhdHasWrist(ID), dhdHasGripper(ID)};
  if (d == nullptr || dhdSetGravityCompensation(DHD_ON, ID) < 0 || dhdEnableForce(DHD_ON, ID) < 0) {
    dhdClose(ID);
    delete d;
    return refuse(why, size, "its forces cannot be switched on: calibrate it by its own program first");
  }
  info->abi = PALPATE_DRIVER_ABI;
  std::snprintf(info->name, sizeof info->name, "%s", dhdGetSystemName(ID));
  info->rate = 1000.0;
  info->force_max = kForceMax;
  info->moment_max = dhdHasActiveWrist(ID) ? kMomentMax : 0.0;
  for (double& length : info->workspace) length = 0.1;
  return d;
}

int palpate_driver_read(void* p, palpate_driver_state* state) {
  const Device& d = *static_cast<Device*>(p);
  double x[3] = {0.0, 0.0, 0.0}, R[3][3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, angle = 0.0;
  const int got = d.wrist ? dhdGetPositionAndOrientationFrame(&x[0], &x[1], &x[2], R, d.id)
                          : dhdGetPosition(&x[0], &x[1], &x[2], d.id);
  if (got < 0 || (d.gripper && dhdGetGripperAngleRad(&angle, d.id) < 0)) return 1;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) state->X_LH[4 * i + j] = R[i][j];
    state->X_LH[4 * i + 3] = x[i];
    state->X_LH[12 + i] = 0.0;
  }
  state->X_LH[15] = 1.0;
  state->has_velocity = 0;
  const unsigned mask = dhdGetButtonMask(d.id);
  state->buttons = acts(mask) | (mask & 15u) * PALPATE_BUTTON_OWN(0);
  state->gripper = d.gripper ? std::abs(angle) : (mask & 8u) ? 0.0 : kOpening;
  return 0;
}

int palpate_driver_write(void* p, const double wrench[6]) {
  const Device& d = *static_cast<Device*>(p);
  return dhdSetForceAndTorque(wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5], d.id) < 0;
}

void palpate_driver_close(void* p) {
  auto* d = static_cast<Device*>(p);
  dhdEnableForce(DHD_OFF, d->id);
  dhdClose(d->id);
  delete d;
}

}  // extern "C"
