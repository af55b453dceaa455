// What the stage `contact` answers and the stages after it read: the touched surfaces and their materials.
#pragma once

#include <array>

#include "palpate/types/spatial.hpp"

namespace palpate {

/// Diagonal stiffness and damping along the axes of W (Eq 8); Coulomb friction.
struct Material {
  Vec3 K = Vec3::Constant(500.0);  ///< stiffness [N/m]
  Vec3 B = Vec3::Constant(0.0);    ///< damping [N s/m]
  double mu = 0.0;                 ///< friction coefficient while it slips [-]
  double mu_static = 0.0;          ///< while it sticks; below mu: as mu [-]
};

/// Contacts at the same time, at most: pairs of a sphere and an object.
inline constexpr int kMaxContacts = 32;

/// One object touched by one sphere of the tool: the spherical proxy region (SPR) on the tip is the first. All in W.
struct Contact {
  int object = -1;              ///< index into the snapshot
  Vec3 p_proxy = Vec3::Zero();  ///< centre of the proxy sphere P, on or outside the surface [m]
  Vec3 normal = Vec3::Zero();   ///< unit, out of the obstacle
  Vec3 delta_x = Vec3::Zero();  ///< p_proxy - p_tool, out of the obstacle (Eq 6, Fig 3) [m]
  double depth = 0.0;           ///< delta_x . normal [m]

  // What contact::Tool adds.
  Vec3 v_surface = Vec3::Zero();  ///< velocity of the touched surface point [m/s]
  Material material{};            ///< stiffness, damping and friction there
  Vec3 F_slope = Vec3::Zero();    ///< from the gradient of the stiffness: -1/2 delta_x^2 grad K [N]
  int sphere = 0;                 ///< index into the tool's spheres, 0 = the SPR on the tip
  Vec3 p_C = Vec3::Zero();        ///< where the proxy touches the surface [m]
  Vec3 p_TS = Vec3::Zero();       ///< from the tool tip T to the sphere's centre S: the force's lever [m]
};

struct ContactSet {
  std::array<Contact, kMaxContacts> contact;
  int size = 0;
  /// The tool was inside an object at its first step: the proxy began at the nearest point outside.
  bool started_inside = false;
};

}  // namespace palpate
