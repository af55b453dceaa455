// Timing statistics of a real-time thread as Python dicts.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include "palpate/loop/realtime.hpp"
#include "types.hpp"

namespace palpate::bindings {

namespace nb = nanobind;

inline Fields percentiles(const loop::Histogram& h) {
  Fields d;
  d["p50"] = h.percentile_us(0.5);
  d["p99"] = h.percentile_us(0.99);
  d["p999"] = h.percentile_us(0.999);
  d["max"] = h.max_us();
  return d;
}

inline Fields punctuality(const loop::RealTimeThread& thread) {
  const loop::Punctuality& p = thread.punctuality();
  Fields d;
  d["lateness_us"] = percentiles(p.lateness);
  Fields slack;
  slack["p50"] = p.slack.percentile_us(0.5);
  slack["p01"] = p.slack.percentile_us(0.01);
  slack["p001"] = p.slack.percentile_us(0.001);
  d["slack_us"] = slack;
  d["missed_ticks"] = p.missed.load();
  d["ticks"] = p.ticks.load();
  d["scheduler"] = thread.scheduler();
  return d;
}

}  // namespace palpate::bindings
