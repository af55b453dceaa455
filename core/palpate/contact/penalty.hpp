// Method `penalty`: the nearest point of the surface at this instant, without any state. For comparison.
//
//   delta_x = (r - phi) n,     n = (x - q) / phi,     x: sphere centre, q: nearest point, phi: its signed distance
//
// The result is right while the nearest point is on the side from which the tool came. Beyond the middle of a plate or
// the medial axis of a body the tool pops through. On a mesh the normal is that of the facet. The method needs only
// Surface::nearest() and works on every surface.
#pragma once

#include "palpate/contact/broad_phase.hpp"
#include "palpate/contact/contact.hpp"

namespace palpate::contact {

/// Contact method without state; see the top of this file.
class Penalty final : public Method {
 public:
  explicit Penalty(const Options& options) : radius_(options.radius), sphere_(options.sphere), near_(options.objects) {}
  void reset() noexcept override {
    set_ = ContactSet();
    near_.reset();
  }
  const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept override;

 private:
  double touch(const scene::Object& object, int index, const Vec3& p_WT, double t) noexcept;

  double radius_;
  int sphere_;
  BroadPhase near_;
  ContactSet set_;
};

}  // namespace palpate::contact
