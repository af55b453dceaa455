// One tick of a session: all signals (the paper's Fig 3 and more), one row of the record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "palpate/types/live.hpp"
#include "palpate/types/status.hpp"

namespace palpate::loop {

/// Largest number of contacts that a tick records one by one.
inline constexpr int kTouches = 16;

/// Number of those that withhold a force, in the order of the signal `F_withheld`. The device: the ramp after a pause
/// of a device on a network, or the limits of the drives.
inline constexpr int kWithholders = 7;

/// Types of a signal. Every element has eight bytes, so that numpy can read a tick as a row without padding.
template <std::size_t n>
using Reals = double[n];
using Bits = std::uint64_t;  ///< bits of Status

/// One tick. signals.inl lists its fields with their units and frames.
struct Tick {
// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): the table builds the fields
#define SIGNAL(stage, type, field, unit, frame, doc, deterministic) type field;
#include "palpate/loop/signals.inl"
#undef SIGNAL
};

/// One row of the table: a signal's name, size and meaning.
struct Signal {
  const char* name;
  std::size_t offset;  ///< offset in Tick [bytes]
  std::size_t size;    ///< number of elements of eight bytes: an integer if the unit is "bits", else doubles
  const char* unit;
  const char* frame;  ///< monogram letter of the frame, or empty
  const char* doc;
  bool deterministic;  ///< false: depends on the machine and is omitted from a lockstep record
  const char* stage;   ///< producer of the signal: the first word of its channel
};

/// The rows of the table.
std::span<const Signal> signals() noexcept;

}  // namespace palpate::loop
