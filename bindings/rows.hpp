// Ticks as rows of a numpy array. A row is the memory of a tick, read as doubles; its status is an integer
// (palpate/record/ticks.py).
#pragma once

#include <nanobind/ndarray.h>

#include <memory>
#include <utility>
#include <vector>

#include "palpate/loop/tick.hpp"
#include "types.hpp"

namespace palpate::bindings {

inline constexpr std::size_t kColumns = sizeof(loop::Tick) / sizeof(double);

inline Table to_rows(std::vector<loop::Tick>&& ticks) {
  auto owner = std::make_unique<std::vector<loop::Tick>>(std::move(ticks));
  auto* data = reinterpret_cast<double*>(owner->data());
  const std::size_t n = owner->size();
  nanobind::capsule capsule(owner.release(), [](void* p) noexcept { delete static_cast<std::vector<loop::Tick>*>(p); });
  return Table(data, {n, kColumns}, capsule);
}

inline Array to_row(const loop::Tick& tick) { return Array(nanobind::cast(to_rows({tick}))[nanobind::int_(0)]); }

}  // namespace palpate::bindings
