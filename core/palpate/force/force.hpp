// Stage `force`: what the touched surfaces do to the tool (Eqs 6-8, Algorithm 1 lines 7-9, READINGS 1 and 8).
#pragma once

#include "palpate/contact/contact.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::force {

/// The terms, kept apart so that each is recorded. All in W, environment on tool [N].
struct ForceTerms {
  Vec3 F = Vec3::Zero();          ///< F_spring + F_damping
  Vec3 F_spring = Vec3::Zero();   ///< K delta_x
  Vec3 F_damping = Vec3::Zero();  ///< -B xdot along the normal; its power is never positive
};

/// Sum over the contacts of
///
///   F = K delta_x - n (n^T B n) n . (v_WT - v_surface),   n . F >= 0
///
/// with K = stiffness_scale * material.K, B = damping_scale * material.B, diagonal along the axes of W.
/// Algorithm 1 projects the velocity on the normal; projecting B on it as well keeps an anisotropic B
/// dissipative. A surface pushes, never pulls: damping on the way out stops at the spring's force.
/// No contact: exactly zero.
///
/// v_WT: tool velocity in W [m/s] (the handle's, mapped: collocated damping, READINGS 1).
[[nodiscard]] ForceTerms step(const contact::ContactSet& contacts, const Vec3& v_WT, double stiffness_scale,
                              double damping_scale) noexcept;

}  // namespace palpate::force
