// Coulomb friction of a proxy, with sticking and slipping.
//
// The proxy without friction is at p. The proxy with friction is at an anchor a, which may lag behind p and pulls the
// tool back. With the lag s = a - p in the tangent plane, the depth d along the normal and the stiffness K, the
// friction force is K |s| and the normal force is K d:
//
//   stick:  a stays,                                       until |s| > mu_static d
//   slip:   a is dragged along, so that |s| <= mu d,       until |s| < max(mu - (mu_static - mu) / 2, mu / 2) d
//
// Slipping ends only when the tool has moved back by half the difference between static and dynamic friction. This
// hysteresis keeps a noisy tool that creeps or rests at the slip limit from switching in every tick. The law uses
// positions and no velocities, so the force does not chatter at rest. Dragging the anchor only shortens the lag, so no
// closed path of the tool gains energy.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// Friction state of one proxy on one object.
class Friction {
 public:
  /// Ends the contact: the next step() starts with a new anchor.
  void release() noexcept { touching_ = false; }
  /// Computes the lag a - p in the tangent plane [m]. p: centre of the proxy without friction [m]; normal: unit surface
  /// normal. Both are expressed in a frame that moves with the surface. depth: penetration depth, above 0 [m]. mu,
  /// mu_static: friction coefficients [-]; a mu_static below mu counts as mu.
  Vec3 step(const Vec3& p, const Vec3& normal, double depth, double mu, double mu_static) noexcept;
  /// Moves the anchor with a surface that deforms, by `shift` [m].
  void carry(const Vec3& shift) noexcept { anchor_ += shift; }
  /// True while the proxy slips.
  [[nodiscard]] bool slipping() const noexcept { return slipping_; }

 private:
  bool touching_ = false;
  bool slipping_ = false;
  Vec3 anchor_ = Vec3::Zero();
};

}  // namespace palpate::contact
