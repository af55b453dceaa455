// Method `approach-velocity`: out is where the tool came from, n = -v / |v| with its velocity just before the collision
// (section 3.1, rejected there).
//
// The normal is kept until the tool is free again; depth as in Algorithm 1. Right only where the tool approaches along
// the surface's normal: the error is the angle of approach, and it stays whatever the tool slides over. A rest before
// the contact keeps the last direction of motion; a tool that appears in contact has none: no force.
#pragma once

#include "palpate/contact/collision_method.hpp"

namespace palpate::contact {

class ApproachVelocity final : public Rule {
 public:
  void free(const Vec3& v_OT) override {
    if (v_OT.squaredNorm() > 0.0) n_ = -v_OT.normalized();
  }
  algorithm1::Plane touch(const Collision& c) override {
    return {n_, algorithm1::average(c.points, n_, c.p_OT).p_proxy};
  }

 private:
  Vec3 n_ = Vec3::Zero();
};

}  // namespace palpate::contact
