#include "tissue/bindings.hpp"

namespace nb = nanobind;

NB_MODULE(_tissue, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "Surfaces that deform or come from a sensor: soft bodies and point clouds.";
  nb::module_::import_("palpate._core");  // their base class Surface and snapshots are objects of _core
  palpate::bindings::bind_clouds(m);
  palpate::bindings::bind_bodies(m);
}
