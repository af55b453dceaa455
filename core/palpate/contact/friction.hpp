// Coulomb friction of one tool sphere on one object, with sticking and slipping.
//
// A spring of the contact's stiffness k holds the tool at an anchor. It acts across the anchor's normal n_a alone, so
// its energy depends on the tool's position x and on nothing else while the tool sticks:
//
//   lag s = (I - n_a n_a^T) (x_anchor - x),      E = 1/2 k |s|^2,      F = -dE/dx = k s
//
// F is the exact gradient of E on every surface: curved, faceted, at edges and in corners. The force of a lag between
// proxies would need the Jacobian of the map from tool to proxy, (R + r)/(R + r - depth) on a sphere.
//
// With the surface normal n at the tool, the depth d and the load N = min(d, d + n.s), the tool
//
//   sticks: n_a and x_anchor stay,           until |s - n n.s| > mu_static N
//   slips:  |s - n n.s| <= mu N and n_a turns towards n, until |s - n n.s| < max(mu - (mu_static - mu) / 2, mu / 2) N
//
// Slipping begins at mu_static N; this limit then falls to mu N by at most kBreakAway in force per time. It ends only
// when the tool has moved back by half the difference between static and dynamic friction. This hysteresis keeps a
// noisy tool that creeps or rests at the slip limit from switching in every tick. The force at rest is that of
// positions, so it does not chatter. Slipping only shortens the lag and turning n_a keeps its length, so no closed path
// of the tool gains energy. Where k changes, k |s|^2 stays.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// Friction state of one sphere on one object.
class Friction {
 public:
  /// What the law depends on in one tick. Vectors are expressed in a frame that moves with the object.
  struct Load {
    Vec3 x = Vec3::Zero();        ///< centre of the sphere relative to the surface, which may deform [m]
    Vec3 normal = Vec3::UnitZ();  ///< unit surface normal at the sphere
    double depth = 0.0;           ///< penetration depth, above 0 [m]
    double k = 1.0;               ///< stiffness along the normal, above 0 [N/m]
    double mu = 0.0;              ///< friction coefficient while slipping [-]
    double mu_static = 0.0;       ///< friction coefficient while sticking; a value below mu counts as mu [-]
    double dt = 0.0;              ///< time since the previous tick [s]
  };

  /// Largest fall of the slip limit after the tool breaks away [N/s].
  static constexpr double kBreakAway = 20.0;

  /// Ends the contact: the next step() starts with a new anchor.
  void release() noexcept { touching_ = false; }
  /// Computes the lag s [m]; the friction force is k s.
  const Vec3& step(const Load& load) noexcept;
  /// Moves the anchor with a surface that deforms, by `shift` [m].
  void carry(const Vec3& shift) noexcept { x_ += shift; }
  /// True while the tool slips.
  [[nodiscard]] bool slipping() const noexcept { return slipping_; }

 private:
  void slip(const Load& load) noexcept;
  void turn_towards(const Vec3& normal, double share) noexcept;

  bool touching_ = false;
  bool slipping_ = false;
  double mu_slip_ = 0.0;     // slip limit, from mu_static down to mu
  double k_ = 0.0;           // k of the previous tick
  Vec3 x_ = Vec3::Zero();    // x of the previous tick
  Vec3 lag_ = Vec3::Zero();  // across anchor_normal_
  Vec3 anchor_normal_ = Vec3::Zero();
};

}  // namespace palpate::contact
