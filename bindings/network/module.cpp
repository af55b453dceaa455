// The extension `_network`: teleoperation across a network.
#include "network/bindings.hpp"

NB_MODULE(_network, m) {
  nanobind::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "Teleoperation across a network: emulated links, packets, both ends, and simulated trials.";
  nanobind::module_::import_("palpate._core");
  palpate::bindings::bind_link(m);
  palpate::bindings::bind_packets(m);
  palpate::bindings::bind_ends(m);
  palpate::bindings::bind_trial(m);
  palpate::bindings::bind_loops(m);
}
