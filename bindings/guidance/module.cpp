#include "guidance/bindings.hpp"

namespace nb = nanobind;

NB_MODULE(_guidance, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "Virtual fixtures, and the stage of the haptic cycle that renders them.";
  nb::module_::import_("palpate._core");  // frames, surfaces and options are objects of _core
  palpate::bindings::bind_geometries(m);
  palpate::bindings::bind_fixtures(m);
  palpate::bindings::bind_run(m);
}
