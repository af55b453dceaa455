// The extension `_verify`: one function for each file of this folder.
#pragma once

#include <nanobind/nanobind.h>

namespace palpate::bindings {

void bind_axis(nanobind::module_& m);
void bind_contacts(nanobind::module_& m);
void bind_guidance_bench(nanobind::module_& m);
void bind_soak(nanobind::module_& m);
void bind_stability(nanobind::module_& m);

}  // namespace palpate::bindings
