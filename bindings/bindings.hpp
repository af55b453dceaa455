// Each stage binds itself in a file of its own; this list is the module.
#pragma once

#include <nanobind/nanobind.h>

namespace palpate::bindings {

void bind_loop(nanobind::module_& m);

}  // namespace palpate::bindings
