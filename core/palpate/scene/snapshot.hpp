// An immutable description of the scene. It is never edited, but replaced as a whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpate/scene/approach.hpp"
#include "palpate/scene/deformable.hpp"
#include "palpate/scene/material.hpp"
#include "palpate/scene/motion.hpp"
#include "palpate/scene/surface.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// Maximum number of objects in a snapshot.
inline constexpr int kMaxObjects = 512;

/// One object of the scene: its surface, pose, material and motion.
struct Object {
  std::string name;                        ///< name in the scene file
  std::shared_ptr<const Surface> surface;  ///< surface in the object's frame O
  Pose X_WO;                               ///< pose of the object at rest
  Material material;                       ///< material outside of all regions
  std::vector<Region> regions;             ///< regions with another material; later regions cover earlier ones
  Motion motion;                           ///< motion from the rest pose
  bool is_virtual = true;                  ///< true: the contact stage renders the object
  bool is_real = true;                     ///< true: the tool of a simulated follower with drives collides with it
  std::optional<LiveOptions> live;  ///< of an object whose pose is set while the loop runs; it has no motion then
  /// Part of the change of X_WO since the last tick that corrects the object's place without moving the object:
  /// friction keeps its anchors in W [m].
  Vec3 correction = Vec3::Zero();

  /// Pose of the object in W at time t [s].
  [[nodiscard]] Pose pose(double t) const noexcept { return motion.pose(X_WO, t); }
  /// Material of the object at p_O, expressed in O [m].
  [[nodiscard]] LocalMaterial material_at(const Vec3& p_O) const noexcept {
    LocalMaterial out{material};
    for (const Region& region : regions) out.blend(region, p_O);
    return out;
  }
};

/// All objects of the scene.
struct Snapshot {
  std::vector<Object> objects;  ///< at most kMaxObjects objects
  /// Unique number of a snapshot in which only live objects and soft bodies change; 0: any object may (seal).
  std::uint64_t revision = 0;
  std::vector<std::size_t> soft;  ///< indices of its soft bodies, unless revision is 0
};

/// A copy of `scene` with its own deformable surfaces, at rest, except that it takes those of `before` that have the
/// same id.
Snapshot with_own_deformables(Snapshot scene, const Snapshot* before = nullptr);
/// Gives the snapshot its revision: from now on only its live objects and soft bodies change.
void seal(Snapshot& scene);

/// Calls visit(i, body) for each soft body, in the order of the objects.
template <class Visit>
void for_each_soft(const Snapshot& scene, Visit&& visit) noexcept {
  const bool listed = scene.revision != 0;
  const std::size_t count = listed ? scene.soft.size() : scene.objects.size();
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = listed ? scene.soft[k] : k;
    if (Deformable* const soft = scene.objects[i].surface->deformable(); soft != nullptr) visit(i, *soft);
  }
}

}  // namespace palpate::scene
