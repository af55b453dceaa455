// The extension `_core`: one function for each file of this folder.
#pragma once

#include <nanobind/nanobind.h>

namespace palpate::bindings {

void bind_arm(nanobind::module_& m);
void bind_camera(nanobind::module_& m);
void bind_contact(nanobind::module_& m);
void bind_crtk(nanobind::module_& m);
void bind_device(nanobind::module_& m);
void bind_force(nanobind::module_& m);
void bind_guidance_interface(nanobind::module_& m);
void bind_live(nanobind::module_& m);
void bind_loop(nanobind::module_& m);
void bind_mapping(nanobind::module_& m);
void bind_plant(nanobind::module_& m);
void bind_surfaces(nanobind::module_& m);
void bind_scene(nanobind::module_& m);
void bind_simulation(nanobind::module_& m);
void bind_bodies(nanobind::module_& m);
void bind_stability(nanobind::module_& m);
void bind_torque(nanobind::module_& m);
void bind_world(nanobind::module_& m);

}  // namespace palpate::bindings
