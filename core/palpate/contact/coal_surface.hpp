// Collision points of a sphere and the meshes of a scene, by Coal (FCL's successor). Coal allocates: never in the
// cycle.
//
// Its contacts are what the paper's section 3.1 complains about: one per triangle near the sphere, in the order of the
// tree, each with a normal from the triangle to the sphere's *centre*. While the centre is outside, these lean around
// the surface normal; once it is below the surface they point inwards; a sphere wholly inside touches nothing.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>

#include "palpate/scene/snapshot.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// Contacts that are asked for, at most.
inline constexpr int kMaxCollisionPoints = 15;

/// Where the sphere meets one triangle. In the object's frame O.
struct CollisionPoint {
  Vec3 p = Vec3::Zero();       ///< on the triangle [m]
  Vec3 n = Vec3::Zero();       ///< from the triangle to the sphere, unit
  Vec3 n_face = Vec3::Zero();  ///< of the triangle's plane, outwards, unit; zero for a triangle without area
  double depth = 0.0;          ///< how far along n the sphere must go to be free of this triangle [m]
};

struct CollisionPoints {
  std::array<CollisionPoint, kMaxCollisionPoints> point;
  int size = 0;
};

class CoalSurface {
 public:
  explicit CoalSurface(double radius);
  ~CoalSurface();
  CoalSurface(const CoalSurface&) = delete;
  CoalSurface& operator=(const CoalSurface&) = delete;

  /// Builds a tree for each mesh that has none yet and forgets those that left the scene.
  void prepare(const scene::Snapshot& scene);
  /// Points of one object of a prepared scene for the sphere's centre p_OT. Throws std::logic_error when not prepared.
  [[nodiscard]] CollisionPoints collide(const scene::Object& object, const Vec3& p_OT) const;

 private:
  struct Tree;
  struct Sphere;
  std::unique_ptr<Sphere> sphere_;
  std::map<std::uint64_t, std::unique_ptr<Tree>> trees_;  ///< by the mesh's id
};

}  // namespace palpate::contact
