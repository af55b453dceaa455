/* Stand-in for OpenHaptics: a device that moves 30 mm down (y) within 300 servo ticks
 * once the file of the environment variable HD_GO exists. The force of each tick goes to
 * the file of the environment variable HD_LOG; with HD_FAIL it fails 700 ticks after that. */
#include "HD/hd.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static HDSchedulerCallback callback;
static void* context;
static pthread_t thread;
static volatile int running;
static int moved, failed;
static double force[3];

HHD hdInitDevice(HDstring name) {
  failed = name != NULL && strcmp(name, "absent") == 0;
  return 1;
}
void hdMakeCurrentDevice(HHD id) { (void)id; }
void hdDisableDevice(HHD id) { (void)id; }
void hdBeginFrame(HHD id) { (void)id; }
void hdEndFrame(HHD id) {
  (void)id;
  failed = getenv("HD_FAIL") != NULL && moved > 700;
}
void hdGetDoublev(HDenum name, HDdouble* v) {
  if (name == HD_NOMINAL_MAX_FORCE) {
    v[0] = 3.3;
    return;
  }
  memset(v, 0, 16 * sizeof *v);
  v[0] = v[5] = v[10] = v[15] = 1.0;
  v[13] = -30.0 * fmin(1.0, moved / 300.0); /* column-major: the position is in 12, 13, 14 [mm] */
}
void hdGetIntegerv(HDenum name, HDint* v) { (void)name, v[0] = 0; }
void hdSetDoublev(HDenum name, const HDdouble* v) { (void)name, memcpy(force, v, sizeof force); }
void hdEnable(HDenum what) { (void)what; }
HDErrorInfo hdGetError(void) {
  const HDErrorInfo info = {(HDerror)failed, 0, 1};
  return info;
}
static void* serve(void* unused) {
  FILE* log = fopen(getenv("HD_LOG"), "w");
  while (running) {
    if (moved > 0 || access(getenv("HD_GO"), F_OK) == 0) ++moved;
    if (callback(context) == HD_CALLBACK_DONE) running = 0; /* the driver has set its last force */
    fprintf(log, "%g %g %g\n", force[0], force[1], force[2]);
    nanosleep(&(struct timespec){0, 1000000}, NULL);
  }
  fclose(log);
  return unused;
}
HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback function, void* data, HDushort priority) {
  callback = function, context = data, (void)priority;
  return 1;
}
void hdStartScheduler(void) {
  moved = 0, running = 1;
  pthread_create(&thread, NULL, serve, NULL);
}
void hdStopScheduler(void) {
  running = 0;
  pthread_join(thread, NULL);
}
void hdUnschedule(HDSchedulerHandle handle) { (void)handle; }
