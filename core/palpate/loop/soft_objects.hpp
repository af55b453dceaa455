// Soft objects of the scene in a tick: the contacts act on them, and they move.
#pragma once

#include "palpate/contact/tool.hpp"
#include "palpate/force/force.hpp"
#include "palpate/scene/deformable.hpp"
#include "palpate/scene/snapshot.hpp"

namespace palpate::loop {

/// Advances the soft objects by a tick of dt [s] under the contacts that were found at t [s], with their forces. tool:
/// the contact stage. Nothing allocates, locks or throws.
void advance_soft(const scene::Snapshot& scene, const contact::Tool& tool, const ContactSet& contacts,
                  const force::ForceTerms& forces, double t, double dt) noexcept;
/// Sum of the energies of all soft objects; the flags are set if they are for any object.
[[nodiscard]] scene::DeformableState soft_state(const scene::Snapshot& scene) noexcept;

}  // namespace palpate::loop
