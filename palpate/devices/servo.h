/* A vendor's servo callback beside Palpate's thread: the state goes out and the force comes in, under a lock that the
 * callback never waits for. A force or a state older than 20 ms is not used, also while the lock is held. For drivers
 * in C and C++. */
#ifndef PALPATE_SERVO_H
#define PALPATE_SERVO_H

#include <pthread.h>
#include <string.h>
#include <time.h>

#include "driver.h"

#define PALPATE_SERVO_SILENT 0.02 /* age after which a force or a state is not used [s] */
#define PALPATE_SERVO_OPENING 0.5 /* angle of the gripper while its button is released [rad] */

typedef struct palpate_servo {
  pthread_mutex_t lock;
  palpate_driver_state state;
  double force[3];
  double written, measured; /* times [s] */
  int failed;
} palpate_servo;

static inline double palpate_servo_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* In the callback: hands over a state and takes the force (3) [N]. Returns 0, and leaves the force as it is, if
 * Palpate's thread holds the lock just now; one that was stopped while it held the lock leaves no force. */
static inline int palpate_servo_exchange(palpate_servo* s, const palpate_driver_state* state, double force[3]) {
  const double t = palpate_servo_now();
  if (pthread_mutex_trylock(&s->lock) != 0) {
    if (t - s->measured < PALPATE_SERVO_SILENT) return 0; /* the callback alone writes this time */
    memset(force, 0, 3 * sizeof *force);
    return 1;
  }
  s->state = *state;
  s->measured = t;
  if (t - s->written >= PALPATE_SERVO_SILENT) memset(s->force, 0, sizeof s->force);
  memcpy(force, s->force, sizeof s->force);
  pthread_mutex_unlock(&s->lock);
  return 1;
}

/* palpate_driver_read: an old state is left out, so that it stays not a number and the force is zero. */
static inline int palpate_servo_read(palpate_servo* s, palpate_driver_state* state) {
  pthread_mutex_lock(&s->lock);
  if (palpate_servo_now() - s->measured < PALPATE_SERVO_SILENT) *state = s->state;
  const int failed = s->failed;
  pthread_mutex_unlock(&s->lock);
  return failed;
}

/* palpate_driver_write, for a device without moments. */
static inline int palpate_servo_write(palpate_servo* s, const double wrench[6]) {
  pthread_mutex_lock(&s->lock);
  memcpy(s->force, wrench, sizeof s->force);
  s->written = palpate_servo_now();
  const int failed = s->failed;
  pthread_mutex_unlock(&s->lock);
  return failed;
}

/* Waits until the callback has taken the last force, or has run at all, for so many milliseconds at most: after it is
 * started, so that there is a state to read, and before it is removed, so that zero has arrived. */
static inline void palpate_servo_wait(palpate_servo* s, int most) {
  const struct timespec pause = {0, 1000000};
  for (int i = 0; i < most; ++i) {
    pthread_mutex_lock(&s->lock);
    const int taken = s->measured > s->written;
    pthread_mutex_unlock(&s->lock);
    if (taken) return;
    nanosleep(&pause, NULL);
  }
}

#endif
