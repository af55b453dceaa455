// Stage `force`: what the touched surfaces do to the tool (Eqs 6-8, Algorithm 1 lines 7-9).
#pragma once

#include <array>

#include "palpate/types/contact.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::force {

/// Where the force on the tool that the hand is given comes from.
enum class Source {
  contact,   ///< the law below, on the virtual surfaces that are touched
  estimate,  ///< the torques of the follower's drives (estimate.hpp): what a real instrument touches
  both,      ///< their sum: virtual guidance beside what is really touched
};

/// The terms, kept apart so that each is recorded. All in W, environment on tool.
struct ForceTerms {
  Vec3 F = Vec3::Zero();                          ///< F_spring + F_damping [N]
  Vec3 F_spring = Vec3::Zero();                   ///< K delta_x [N]
  Vec3 F_damping = Vec3::Zero();                  ///< -B xdot along the normal; its power is never positive [N]
  Vec3 torque = Vec3::Zero();                     ///< of F about the tool tip T [N m]
  Vec3 t_damping = Vec3::Zero();                  ///< the damping's part of it [N m]
  std::array<Wrench, kMaxContacts> of_contact{};  ///< force and torque of each contact, in their order
};

/// Sum over the contacts of
///
///   F = K delta_x + F_slope - n (n^T B n) n . (v_WS - v_surface),   n . F >= 0,   v_WS = v_WT + w_WT x p_TS
///   torque = p_TS x F
///
/// with S the sphere that touches, K = stiffness_scale * material.K, B = damping_scale * material.B, diagonal along the
/// axes of W. F_slope = -1/2 delta_x^2 grad K makes the spring the gradient of 1/2 delta_x^T K delta_x where K changes
/// from place to place: a hard lump pushes the tool aside, and pressing beside it to let go on it earns nothing.
/// Algorithm 1 projects the velocity on the normal; projecting B on it as well keeps an anisotropic B
/// dissipative. A surface pushes, never pulls: damping on the way out stops at the spring's force.
/// No contact: exactly zero.
///
/// V_WT: twist of the tool in W (the handle's, mapped: collocated damping). As the velocity of each sphere
/// is that of a tool held by this twist, the damping's power on it, F . v + torque . w, is never positive.
[[nodiscard]] ForceTerms step(const ContactSet& contacts, const Twist& V_WT, double stiffness_scale,
                              double damping_scale) noexcept;

}  // namespace palpate::force
