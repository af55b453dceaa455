// Coulomb friction of a proxy that sticks and slips.
//
// The proxy without friction is p; a proxy that sticks stays behind at an anchor a, and pulls the tool back to it.
// With the lag s = a - p in the tangent plane and the depth d along the normal, K s is the friction, K d the load:
//
//   stick:  a stays,                                       until |s| > mu_static d
//   slip:   a is dragged along, so that |s| <= mu d,       until |s| < (mu - (mu_static - mu) / 2) d
//
// Slip ends only when the tool has turned back by half of what static friction is above dynamic friction: a noisy
// tool that creeps on, or rests where it slipped last, does not change its mind at every tick. All of it is a matter
// of place, not of velocity, so nothing trembles at rest; and a dragged anchor only ever shortens the lag, so that
// every closed path costs work.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::contact {

class Friction {
 public:
  /// Out of contact.
  void release() noexcept { touching_ = false; }
  /// p: proxy without friction, normal: unit, in a frame that moves with the surface [m]; depth > 0 [m]; coefficients
  /// [-], mu_static below mu counts as mu. Answers the lag, in the tangent plane [m].
  Vec3 step(const Vec3& p, const Vec3& normal, double depth, double mu, double mu_static) noexcept;
  [[nodiscard]] bool slipping() const noexcept { return slipping_; }

 private:
  bool touching_ = false;
  bool slipping_ = false;
  Vec3 anchor_ = Vec3::Zero();
};

}  // namespace palpate::contact
