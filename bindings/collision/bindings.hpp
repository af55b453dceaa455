// The extension `_collision`: one function for each file of this folder.
#pragma once

#include <nanobind/nanobind.h>

namespace palpate::bindings {

void bind_algorithm1(nanobind::module_& m);

}  // namespace palpate::bindings
