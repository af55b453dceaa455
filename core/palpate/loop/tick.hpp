// One tick of a session: every signal of the paper's Fig 3, one row of the record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "palpate/types/status.hpp"

namespace palpate::loop {

/// Touches of a tick that are recorded one by one.
inline constexpr int kTouches = 16;

/// Types of a signal. Every element has eight bytes, so that numpy sees a tick as a row without padding.
template <std::size_t n>
using Reals = double[n];
using Bits = std::uint64_t;  ///< bits of Status

/// The fields, their units and frames: signals.inl.
struct Tick {
// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): the table makes the fields
#define SIGNAL(stage, type, field, unit, frame, doc, deterministic) type field;
#include "palpate/loop/signals.inl"
#undef SIGNAL
};

/// One row of the table: a signal's name, size and meaning.
struct Signal {
  const char* name;
  std::size_t offset;  ///< bytes into Tick
  std::size_t size;    ///< elements of eight bytes: one whole number when the unit is "bits", doubles otherwise
  const char* unit;
  const char* frame;  ///< monogram letter, empty when there is none
  const char* doc;
  bool deterministic;  ///< false: depends on the machine, kept out of a lockstep record
  const char* stage;   ///< that produces it: the first word of its channel
};

std::span<const Signal> signals() noexcept;

}  // namespace palpate::loop
