/* Driver for Touch, Phantom and Geomagic devices by the vendor's OpenHaptics (HDAPI), which must be installed:
 *
 *     cc -O2 -shared -fPIC -I FOLDER_OF_driver.h openhaptics.c -o openhaptics.so -lHD
 *
 *     arms: {leader: {driver: ./openhaptics.so}}            # the default device, or openhaptics.so:NAME
 *
 * HDAPI calls a servo callback at 1 kHz (servo.h). HDAPI has millimetres and column-major matrices; x is right, y up,
 * z towards the user. Button 1 is the clutch, 2 closes the gripper, 3 and 4 are the pedals camera and coagulation.
 * Judged with a stand-in of HDAPI, not with a device. */
#include <HD/hd.h>
#include <stdio.h>
#include <stdlib.h>

#include "servo.h"

typedef struct device {
  palpate_servo servo;
  HHD id;
  HDSchedulerHandle callback;
} device;

static void convert(const double transform[16], int buttons, palpate_driver_state* s) {
  memset(s, 0, sizeof *s);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      s->X_LH[4 * row + column] = transform[4 * column + row] * (column == 3 && row < 3 ? 1e-3 : 1.0);
  if (buttons & HD_DEVICE_BUTTON_1) s->buttons |= PALPATE_BUTTON_CLUTCH;
  if (buttons & HD_DEVICE_BUTTON_3) s->buttons |= PALPATE_BUTTON_CAMERA;
  if (buttons & HD_DEVICE_BUTTON_4) s->buttons |= PALPATE_BUTTON_COAG;
  s->buttons |= ((unsigned)buttons & 15u) * PALPATE_BUTTON_OWN(0);
  s->gripper = (buttons & HD_DEVICE_BUTTON_2) ? 0.0 : PALPATE_SERVO_OPENING;
}

static HDCallbackCode HDCALLBACK servo(void* data) {
  device* d = data;
  palpate_driver_state state;
  HDdouble transform[16], force[3] = {0.0, 0.0, 0.0};
  HDint buttons = 0;
  int set = 1;
  hdBeginFrame(d->id);
  hdGetDoublev(HD_CURRENT_TRANSFORM, transform);
  hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);
  const int failed = HD_DEVICE_ERROR(hdGetError()); /* also of the frame before: no pose goes out, the force is zero */
  if (!failed) {
    convert(transform, buttons, &state);
    set = palpate_servo_exchange(&d->servo, &state, force);
  }
  if (set) hdSetDoublev(HD_CURRENT_FORCE, force);
  hdEndFrame(d->id);
  if (!failed) return HD_CALLBACK_CONTINUE;
  d->servo.failed = 1;
  return HD_CALLBACK_DONE;
}

void* palpate_driver_open(const char* argument, palpate_driver_info* info, char* why, size_t size) {
  device* d = calloc(1, sizeof *d);
  HDdouble force_max = 0.0;
  if (d == NULL) return NULL;
  d->id = hdInitDevice(argument[0] ? argument : HD_DEFAULT_DEVICE);
  if (HD_DEVICE_ERROR(hdGetError())) {
    snprintf(why, size, "OpenHaptics finds no device %s: check its cable and its setup program", argument);
    free(d);
    return NULL;
  }
  pthread_mutex_init(&d->servo.lock, NULL);
  hdMakeCurrentDevice(d->id);
  hdGetDoublev(HD_NOMINAL_MAX_FORCE, &force_max);
  hdEnable(HD_FORCE_OUTPUT);
  d->callback = hdScheduleAsynchronous(servo, d, HD_MAX_SCHEDULER_PRIORITY);
  hdStartScheduler();
  palpate_servo_wait(&d->servo, 500);
  info->abi = PALPATE_DRIVER_ABI;
  snprintf(info->name, sizeof info->name, "OpenHaptics %s", argument);
  info->rate = 1000.0;
  info->force_max = force_max;
  info->workspace[0] = 0.16, info->workspace[1] = 0.12, info->workspace[2] = 0.07;
  return d;
}

int palpate_driver_read(void* p, palpate_driver_state* state) {
  return palpate_servo_read(&((device*)p)->servo, state);
}

int palpate_driver_write(void* p, const double wrench[6]) { return palpate_servo_write(&((device*)p)->servo, wrench); }

void palpate_driver_close(void* p) {
  device* d = p;
  palpate_servo_wait(&d->servo, 25);
  hdStopScheduler();
  hdUnschedule(d->callback);
  hdDisableDevice(d->id);
  pthread_mutex_destroy(&d->servo.lock);
  free(d);
}
