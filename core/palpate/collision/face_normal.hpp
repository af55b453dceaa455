// Method `face-normal`: the normals of the faces, precomputed for the whole mesh (section 3.1, rejected there because
// of the cost).
//
// Each collision point has the normal of its triangle. Line 4 of Algorithm 1 averages these normals, and the contact
// plane passes through the deepest point. The result is right on a plane while the sphere touches it, even with the
// centre below the plane. Near an edge the normal is the mean of the faces in reach, and it jumps when faces enter or
// leave. The third approach of section 3.1, the sum of the *collision* normals ("adjusted normals"), is the method
// `paper-alg1`.
#pragma once

#include "palpate/collision/collision_method.hpp"

namespace palpate::collision {

/// Mean of the face normals; see the top of this file.
class FaceNormal final : public NormalRule {
 public:
  void free(const Vec3& /*v_OT*/) override { n_.setZero(); }
  algorithm1::GrownPlane touch(const Collision& c) override {
    CollisionPoints faces = c.points;
    for (CollisionPoint& point : faces.point) point.n = point.n_face;
    n_ = algorithm1::average_normal(faces, n_);
    return algorithm1::through_deepest(c.points, n_, c.p_OT, c.radius);
  }

 private:
  Vec3 n_ = Vec3::Zero();  // normal of the previous collision, kept where the face normals cancel
};

}  // namespace palpate::collision
