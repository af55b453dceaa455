#include "bindings.hpp"

namespace nb = nanobind;

NB_MODULE(_core, m) {
  nb::set_leak_warnings(false);  // objects that live until the interpreter ends are not leaks
  m.doc() = "Palpate's C++ core: the stages of the haptic cycle (see ARCHITECTURE.md).";
  palpate::bindings::bind_live(m);
  palpate::bindings::bind_scene(m);
  palpate::bindings::bind_world(m);
  palpate::bindings::bind_contact(m);
  palpate::bindings::bind_guidance_interface(m);
  palpate::bindings::bind_mapping(m);
  palpate::bindings::bind_force(m);
  palpate::bindings::bind_stability(m);
  palpate::bindings::bind_arm(m);
  palpate::bindings::bind_plant(m);
  palpate::bindings::bind_camera(m);
  palpate::bindings::bind_torque(m);
  palpate::bindings::bind_loop(m);
  palpate::bindings::bind_simulation(m);
  palpate::bindings::bind_bodies(m);
  palpate::bindings::bind_crtk(m);
  palpate::bindings::bind_device(m);
}
