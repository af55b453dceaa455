// Method `paper-alg1`: the paper's Algorithm 1 as written.
//
// Its normal is the sum of the normals of the collision points, which section 3.1 calls "adjusted" normals and rejects.
#pragma once

#include "palpate/collision/collision_method.hpp"

namespace palpate::collision {

/// Sum of the collision normals; see the top of this file.
class PaperAlg1 final : public NormalRule {
 public:
  void free(const Vec3& /*v_OT*/) override { n_.setZero(); }
  algorithm1::GrownPlane touch(const Collision& c) override {
    const algorithm1::GrownPlane plane = algorithm1::average(c.points, n_, c.p_OT);
    n_ = plane.n;
    return plane;
  }

 private:
  Vec3 n_ = Vec3::Zero();  // normal of the previous collision, kept where the sum vanishes
};

}  // namespace palpate::collision
