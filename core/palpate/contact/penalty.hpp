// Method `penalty`: the nearest point of the surface at this instant, and no memory. For comparison.
//
//   delta_x = (r - phi) n,     n = (x - q) / phi,     q the nearest point, phi its signed distance
//
// Right as long as the nearest point is on the side one came from: beyond the middle of a plate, or past a medial axis,
// the tool pops through. On a mesh the normal is the facet's. Works on every surface, as it asks `nearest` alone.
#pragma once

#include "palpate/contact/contact.hpp"

namespace palpate::contact {

class Penalty final : public Method {
 public:
  explicit Penalty(const Options& options) : radius_(options.radius) {}
  void reset() noexcept override { set_ = ContactSet(); }
  const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept override;

 private:
  double radius_;
  ContactSet set_;
};

}  // namespace palpate::contact
