// Stage `force`: the force of the touched surfaces on the tool (Eqs 6-8, Algorithm 1 lines 7-9).
#pragma once

#include <array>

#include "palpate/types/contact.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::force {

/// Source of the force on the tool that is rendered to the hand.
enum class Source {
  contact,   ///< the law below, applied to the touched virtual surfaces
  estimate,  ///< the estimate from the follower's drive torques (estimate.hpp): contact of a real instrument
  both,      ///< the sum of both: virtual guidance surfaces in addition to real contact
};

/// Terms of the force, separate so that each can be recorded. All terms are forces of the environment on the tool, in
/// W.
struct ForceTerms {
  Vec3 F = Vec3::Zero();          ///< total force, F_spring + F_damping [N]
  Vec3 F_spring = Vec3::Zero();   ///< spring force, K delta_x + F_grad_K, without the part that pulls [N]
  Vec3 F_damping = Vec3::Zero();  ///< damping force -B xdot along the normal; its power is never positive [N]
  Vec3 torque = Vec3::Zero();     ///< torque of F about the tool tip T [N m]
  Vec3 t_damping = Vec3::Zero();  ///< part of `torque` that the damping causes [N m]
  std::array<Wrench, kMaxContacts> F_contact{};  ///< force and torque of each contact, in the order of the ContactSet
};

/// Force and torque of all contacts: the sum over the contacts of
///
///   F = K d + (n^T K n) lag + F_grad_K - n (n^T B n) n . (v_WS - v_surface),   n . F >= 0,   v_WS = v_WT + w_WT x p_TS
///   torque = p_TS x F
///
/// where S is the touching sphere, d = delta_x - lag the deflection without friction, K = stiffness_scale * material.K
/// and B = damping_scale * material.B. B is diagonal along the axes of W, and so is K for the methods of the paper. The
/// others pass K = n^T K n in all directions, because K d with d along n has a part across the normal that is the
/// gradient of no energy. Where K varies in space,
///
///   F_grad_K = -1/2 (I - r dn/dx)^T d^2 grad K
///
/// makes the spring force the gradient of the potential 1/2 d^T K d: K is that at the deepest point x - r n of the
/// sphere, which moves with the tool by I - r dn/dx. A hard lump therefore pushes the tool aside, and pressing next to
/// the lump and releasing on it gains no energy.
///
/// Algorithm 1 projects the velocity onto the normal. Projecting B onto the normal as well keeps an anisotropic B
/// dissipative. A surface pushes and never pulls: while the tool moves out, the damping force is at most as large as
/// the spring force. Without contact the force is exactly zero.
///
/// V_WT is the twist of the tool in W, mapped from the handle (collocated damping). The velocity of each sphere is that
/// of a rigid tool with this twist, so the power of the damping, F . v + torque . w, is never positive for objects at
/// rest.
[[nodiscard]] ForceTerms step(const ContactSet& contacts, const Twist& V_WT, double stiffness_scale,
                              double damping_scale) noexcept;

}  // namespace palpate::force
