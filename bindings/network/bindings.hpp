// The parts of the extension `_network`.
#pragma once

#include "types.hpp"

namespace palpate::bindings {

void bind_link(nanobind::module_& m);
void bind_packets(nanobind::module_& m);
void bind_ends(nanobind::module_& m);
void bind_trial(nanobind::module_& m);
void bind_loops(nanobind::module_& m);

}  // namespace palpate::bindings
