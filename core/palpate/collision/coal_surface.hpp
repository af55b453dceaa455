// Collision points between a sphere and the meshes of a scene, computed by Coal (the successor of FCL). Coal allocates,
// so this class must not be used in the cycle.
//
// Coal's contacts have the weakness that section 3.1 of the paper describes: one contact per triangle near the sphere,
// in the order of the tree, each with a normal from the triangle to the *centre* of the sphere. While the centre is
// outside, these normals scatter around the surface normal. With the centre below the surface they point inwards, and a
// sphere completely inside has no contacts.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>

#include "palpate/scene/snapshot.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::collision {

/// Maximum number of contacts requested from Coal (Algorithm 1 line 2).
inline constexpr int kMaxCollisionPoints = 15;

/// Contact between the sphere and one triangle. All vectors are expressed in the object's frame O.
struct CollisionPoint {
  Vec3 p = Vec3::Zero();       ///< point on the triangle [m]
  Vec3 n = Vec3::Zero();       ///< unit normal from the triangle to the sphere centre
  Vec3 n_face = Vec3::Zero();  ///< outward unit normal of the triangle; zero for a triangle without area
  double depth = 0.0;          ///< displacement along n that frees the sphere from this triangle [m]
};

/// The first `size` points are valid.
struct CollisionPoints {
  std::array<CollisionPoint, kMaxCollisionPoints> point;
  int size = 0;
};

/// Collision detection between one sphere and meshes.
class CoalSurface {
 public:
  /// radius: radius of the sphere [m].
  explicit CoalSurface(double radius);
  ~CoalSurface();
  CoalSurface(const CoalSurface&) = delete;
  CoalSurface& operator=(const CoalSurface&) = delete;

  /// Builds the bounding volume trees of new meshes and deletes the trees of meshes that have left the scene.
  void prepare(const scene::Snapshot& scene);
  /// Collision points of one object with the sphere centred at p_OT [m]; none for an object that is not a mesh. Throws
  /// std::logic_error if prepare() has not seen the object.
  [[nodiscard]] CollisionPoints collide(const scene::Object& object, const Vec3& p_OT) const;

 private:
  struct Tree;
  struct Sphere;
  std::unique_ptr<Sphere> sphere_;
  std::map<std::uint64_t, std::unique_ptr<Tree>> trees_;  ///< trees by the id of the mesh
};

}  // namespace palpate::collision
