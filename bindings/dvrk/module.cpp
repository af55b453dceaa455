#include "dvrk/bindings.hpp"

namespace nb = nanobind;

NB_MODULE(_dvrk, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "The simulated dVRK (simulators/dvrk), a device that does not depend on the haptic cycle.";
  nb::module_::import_("palpate._core");  // arms and the options of their drives are objects of _core
  palpate::bindings::bind_spec(m);
  palpate::bindings::bind_system(m);
  palpate::bindings::bind_messages(m);
  palpate::bindings::bind_trajectory(m);
}
