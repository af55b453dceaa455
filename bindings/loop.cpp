#include <nanobind/stl/string.h>

#include "bindings.hpp"
#include "palpate/loop/tick.hpp"

namespace nb = nanobind;

namespace palpate::bindings {

void bind_loop(nb::module_& m) {
  m.attr("TICK_BYTES") = sizeof(loop::Tick);
  m.def(
      "signals",
      [] {
        nb::list rows;
        for (const loop::Signal& s : loop::signals()) {
          rows.append(nb::make_tuple(s.name, s.offset, s.size, s.unit, s.frame, s.doc, s.deterministic));
        }
        return rows;
      },
      "The table of signals: (name, byte offset, doubles, unit, frame, doc, deterministic) per row.");
}

}  // namespace palpate::bindings
