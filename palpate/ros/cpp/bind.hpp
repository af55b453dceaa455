// Python bindings of each part; one source file per part.
#pragma once

#include <nanobind/nanobind.h>

namespace palpate::ros {

void bind_haptics(nanobind::module_& m);
void bind_bench(nanobind::module_& m);
void bind_rcl(nanobind::module_& m);
void bind_sim(nanobind::module_& m);

}  // namespace palpate::ros
