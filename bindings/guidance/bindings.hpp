// The extension `_guidance`: one function for each file of this folder.
#pragma once

#include <nanobind/nanobind.h>

namespace palpate::bindings {

void bind_fixtures(nanobind::module_& m);
void bind_geometries(nanobind::module_& m);
void bind_run(nanobind::module_& m);

}  // namespace palpate::bindings
