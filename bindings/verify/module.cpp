#include "verify/bindings.hpp"

namespace nb = nanobind;

NB_MODULE(_verify, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "Independent checks of the core, and single stages and clocks for studies, benchmarks and tests.";
  nb::module_::import_("palpate._guidance");  // fixtures are objects of _guidance, meshes and options of _core
  nb::module_::import_("palpate._tissue");    // soft surfaces are objects of _tissue
  palpate::bindings::bind_axis(m);
  palpate::bindings::bind_contacts(m);
  palpate::bindings::bind_soak(m);
  palpate::bindings::bind_stability(m);
  palpate::bindings::bind_guidance_bench(m);
}
