/* A driver for tests: a mass of 0.3 kg with a damping of 2 N s/m, which moves by the wrench that was written last.
 * The argument "wrong" turns the force around; "old" states an old version; "refuse" cannot be opened;
 * "empty" fills in no pose. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "driver.h"

typedef struct device {
  double p[3], v[3], F[3], sign, last;
} device;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void advance(device* d) {
  const double t = now(), h = 1e-5;
  for (; d->last + h <= t; d->last += h)
    for (int i = 0; i < 3; ++i) {
      d->v[i] += h / 0.3 * (d->sign * d->F[i] - 2.0 * d->v[i]);
      d->p[i] += h * d->v[i];
    }
}

void* palpate_driver_open(const char* argument, palpate_driver_info* info, char* why, size_t size) {
  if (strcmp(argument, "refuse") == 0) {
    snprintf(why, size, "the cable is out");
    return NULL;
  }
  device* d = calloc(1, sizeof *d);
  d->sign = strcmp(argument, "wrong") == 0 ? -1.0 : strcmp(argument, "empty") == 0 ? 0.0 : 1.0;
  d->last = now();
  info->abi = strcmp(argument, "old") == 0 ? 0 : PALPATE_DRIVER_ABI;
  snprintf(info->name, sizeof info->name, "mass");
  info->rate = 1000.0;
  info->force_max = 5.0;
  info->workspace[0] = info->workspace[1] = info->workspace[2] = 0.2;
  return d;
}

int palpate_driver_read(void* p, palpate_driver_state* s) {
  device* d = p;
  advance(d);
  if (d->sign == 0.0) return 0;
  for (int i = 0; i < 16; ++i) s->X_LH[i] = i % 5 == 0 ? 1.0 : 0.0;
  for (int i = 0; i < 3; ++i) s->X_LH[4 * i + 3] = d->p[i];
  return 0;
}

int palpate_driver_write(void* p, const double w[6]) {
  device* d = p;
  advance(d);
  memcpy(d->F, w, sizeof d->F);
  return 0;
}

void palpate_driver_close(void* p) { free(p); }
