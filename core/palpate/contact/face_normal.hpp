// Method `face-normal`: the normals of the faces, computed beforehand for the whole mesh (section 3.1, rejected there
// for what it costs).
//
// Each collision point brings the normal of the triangle it lies on; Algorithm 1's line 4 adds them up, the plane goes
// through the deepest point. Right on a plane as long as the sphere touches it, centre below or not; around an edge it
// is a mean of the faces in reach, and it jumps as faces come and go. Section 3.1's third way, the sum of the
// *collision* normals ("adjusted normals"), is method `paper-alg1`.
#pragma once

#include "palpate/contact/collision_method.hpp"

namespace palpate::contact {

class FaceNormal final : public Rule {
 public:
  void free(const Vec3& /*v_OT*/) override { n_.setZero(); }
  algorithm1::Plane touch(const Collision& c) override {
    CollisionPoints faces = c.points;
    for (CollisionPoint& point : faces.point) point.n = point.n_face;
    n_ = algorithm1::average_normal(faces, n_);
    return algorithm1::through_deepest(c.points, n_, c.p_OT, c.radius);
  }

 private:
  Vec3 n_ = Vec3::Zero();  // of the collision before: kept where the faces cancel each other
};

}  // namespace palpate::contact
