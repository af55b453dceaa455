/* A driver for tests: moves 30 mm down within 150 readings, then rests. The argument names what goes wrong at reading
 * 300; the wrenches written are counted and the last one is kept in a file, after a comma: "hang,/tmp/last". */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "driver.h"

typedef struct device {
  char fault[32];
  FILE* log;
  int count;
} device;

void* palpate_driver_open(const char* argument, palpate_driver_info* info, char* why, size_t size) {
  const char* comma = strchr(argument, ',');
  device* d = calloc(1, sizeof *d);
  if (strcmp(argument, "refuse") == 0) {
    snprintf(why, size, "no licence on this machine");
    free(d);
    return NULL;
  }
  snprintf(d->fault, sizeof d->fault, "%.*s", (int)(comma ? comma - argument : (long)strlen(argument)), argument);
  if (comma) d->log = fopen(comma + 1, "w");
  info->abi = strcmp(argument, "old") == 0 ? 0 : PALPATE_DRIVER_ABI;
  snprintf(info->name, sizeof info->name, "test device");
  info->rate = strcmp(argument, "rate") == 0 ? 1e6 : 1000.0;
  info->force_max = 5.0;
  if (strncmp(d->fault, "handle", 6) == 0) {
    info->resolution = d->fault[6] ? 0.0 : 5e-6; /* "handle without resolution" */
    info->mass = 0.3, info->delay = 1e-3, info->friction = 0.08, info->damping = 0.6;
  }
  info->workspace[0] = info->workspace[1] = info->workspace[2] = 0.1;
  return d;
}

int palpate_driver_read(void* p, palpate_driver_state* s) {
  device* d = p;
  const int wrong = ++d->count > 300;
  const double down = -0.03 * fmin(1.0, d->count / 150.0);
  if (wrong && strcmp(d->fault, "fail") == 0) return 7;
  if (wrong && strcmp(d->fault, "empty") == 0) return 0;
  if (d->count == 301 && strcmp(d->fault, "pause") == 0) nanosleep(&(struct timespec){0, 60000000}, NULL);
  if (wrong && strcmp(d->fault, "hang") == 0)
    for (;;) nanosleep(&(struct timespec){1, 0}, NULL);
  for (int i = 0; i < 16; ++i) s->X_LH[i] = i % 5 == 0 ? 1.0 : 0.0;
  s->X_LH[11] = down;
  if (wrong && strcmp(d->fault, "mirror") == 0) s->X_LH[0] = -1.0;
  if (wrong && strcmp(d->fault, "nan") == 0) s->X_LH[3] = NAN;
  return 0;
}

int palpate_driver_write(void* p, const double w[6]) {
  device* d = p;
  if (d->log) {
    fprintf(d->log, "%d %.9g\n", d->count, sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]));
    fflush(d->log);
  }
  return d->count > 300 && strcmp(d->fault, "write") == 0;
}

void palpate_driver_close(void* p) {
  device* d = p;
  if (d->log) fclose(d->log);
  free(d);
}
