// Result of the stage `contact`, read by the stages after it: the touched surfaces and their materials.
#pragma once

#include <algorithm>
#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate {

/// Material of a surface: diagonal stiffness and damping along the axes of W (Eq 8), and Coulomb friction.
struct Material {
  Vec3 K = Vec3::Constant(500.0);  ///< stiffness [N/m]
  Vec3 B = Vec3::Constant(0.0);    ///< damping [N s/m]
  double mu = 0.0;                 ///< dynamic friction coefficient, while slipping [-]
  double mu_static = 0.0;          ///< static friction coefficient, while sticking; a value below mu counts as mu [-]
};

/// Maximum number of simultaneous contacts. Each contact is a pair of one tool sphere and one object.
inline constexpr int kMaxContacts = 32;

/// Contact of one tool sphere with one object. All vectors are expressed in W.
struct Contact {
  int object = -1;              ///< index of the object in the snapshot
  Vec3 p_proxy = Vec3::Zero();  ///< centre of the proxy sphere P, which stays outside the surface [m]
  Vec3 normal = Vec3::Zero();   ///< unit surface normal, points out of the object
  Vec3 delta_x = Vec3::Zero();  ///< deflection p_WP - p_WS, points out of the object (Eq 6, Fig 3) [m]
  double depth = 0.0;           ///< penetration depth, delta_x . normal without friction [m]
  Mat3 dn = Mat3::Zero();       ///< derivative of `normal` with the sphere's centre, where the material changes [1/m]
  Vec3 carried = Vec3::Zero();  ///< motion of a surface that deforms, relative to its object, since the last tick [m]

  // contact::Tool fills in the fields below.
  Vec3 lag = Vec3::Zero();  ///< part of delta_x by which friction holds the proxy back (contact/friction.hpp) [m]
  /// What `lag` has more once a force that leads over from one shape of a soft body to the next has done so [m].
  Vec3 lag_to_come = Vec3::Zero();
  Vec3 v_surface = Vec3::Zero();  ///< velocity of the touched surface point [m/s]
  Material material{};            ///< stiffness, damping and friction at the contact point
  Vec3 F_grad_K = Vec3::Zero();   ///< force caused by the stiffness gradient (force/force.hpp) [N]
  int sphere = 0;                 ///< index of the tool sphere; 0 is the SPR at the tip
  Vec3 p_C = Vec3::Zero();        ///< contact point C of the proxy sphere on the surface [m]
  double stored = -1.0;           ///< energy stored across the surface of a soft body; negative: a rigid one [J]
  /// A rigid surface stores 1/2 n^T K n stretch^2; negative: 1/2 d^T K d with d = delta_x - lag [m].
  double stretch = -1.0;
  double stiffening = 1.0;   ///< tangent stiffness over K, along the normal [-]
  Vec3 p_TS = Vec3::Zero();  ///< vector from the tool tip T to the sphere centre S, the lever arm of the force [m]
};

/// The spring force of a contact, without the part that pulls, at the stiffness scale 1 and in W [N].
[[nodiscard]] inline Vec3 spring_force(const Contact& c) noexcept {
  const Vec3 &K = c.material.K, &n = c.normal;
  const Vec3 F = K.cwiseProduct(c.delta_x - c.lag) + n.dot(K.cwiseProduct(n)) * c.lag + c.F_grad_K;
  // An anisotropic K may tilt the spring force until it pulls along the normal. The pulling part is not rendered.
  return F - std::min(n.dot(F), 0.0) * n;
}

/// The energy that the springs of a contact store, at the stiffness scale 1 [J].
[[nodiscard]] inline double spring_energy(const Contact& c) noexcept {
  const Vec3 &K = c.material.K, d = c.delta_x - c.lag;
  const double k = c.normal.dot(K.cwiseProduct(c.normal));
  const double rigid = 0.5 * (c.stretch >= 0.0 ? k * c.stretch * c.stretch : d.dot(K.cwiseProduct(d)));
  return (c.stored >= 0.0 ? c.stored : rigid) + 0.5 * k * c.lag.squaredNorm();
}

/// All contacts of one tick; the first `size` entries are valid.
struct ContactSet {
  std::array<Contact, kMaxContacts> contact;
  int size = 0;
  /// True if a sphere was inside an object at its first step, until it leaves the object. Its proxy started at the
  /// nearest point outside.
  bool started_inside = false;
};

}  // namespace palpate
