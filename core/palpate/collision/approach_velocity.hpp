// Method `approach-velocity`: the normal points back to where the tool came from, n = -v / |v|, with the velocity v of
// the tool just before the collision (section 3.1, rejected there).
//
// The normal is kept until the tool is free again; the depth is that of Algorithm 1. The normal is right only if the
// tool approaches along the surface normal. Otherwise its error is the angle of approach, which remains while the tool
// slides. If the tool rests before the contact, the last direction of motion is used. A tool that appears in contact
// has no direction and gets no force.
#pragma once

#include "palpate/collision/collision_method.hpp"

namespace palpate::collision {

/// Normal against the approach velocity; see the top of this file.
class ApproachVelocity final : public NormalRule {
 public:
  void free(const Vec3& v_OT) override {
    if (v_OT.squaredNorm() > 0.0) n_ = -v_OT.normalized();
  }
  algorithm1::GrownPlane touch(const Collision& c) override {
    return {n_, algorithm1::average(c.points, n_, c.p_OT).p_proxy};
  }

 private:
  Vec3 n_ = Vec3::Zero();  // unit normal in O; zero: unknown
};

}  // namespace palpate::collision
