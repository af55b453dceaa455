#include "palpate/loop/tick.hpp"

namespace palpate::loop {
namespace {

constexpr Signal kSignals[] = {
// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): the table builds the list
#define SIGNAL(stage, type, field, unit, frame, doc, deterministic) \
  {#field, offsetof(Tick, field), sizeof(Tick::field) / sizeof(double), unit, frame, doc, deterministic, #stage},
#include "palpate/loop/signals.inl"
#undef SIGNAL
};

}  // namespace

std::span<const Signal> signals() noexcept { return kSignals; }

}  // namespace palpate::loop
