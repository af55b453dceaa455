// The extension `_tissue`: one function for each file of this folder.
#pragma once

#include <nanobind/nanobind.h>

namespace palpate::bindings {

void bind_bodies(nanobind::module_& m);
void bind_clouds(nanobind::module_& m);

}  // namespace palpate::bindings
