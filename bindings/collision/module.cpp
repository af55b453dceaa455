#include "collision/bindings.hpp"
#include "palpate/collision/methods.hpp"

namespace nb = nanobind;

NB_MODULE(_collision, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "The paper's contact methods, on collisions of triangles; the import adds them to those of the core.";
  nb::module_::import_("palpate._core");  // meshes and options are objects of _core
  palpate::collision::register_methods();
  palpate::bindings::bind_algorithm1(m);
}
