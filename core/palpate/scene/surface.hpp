// Interface of touchable surfaces. Meshes, primitives and distance fields all answer the same nearest-point query.
#pragma once

#include <cstdint>

#include "palpate/types/spatial.hpp"

namespace palpate::scene {

class Deformable;
class Mesh;

/// Nearest point of a surface to a query point. All vectors are expressed in the surface's frame O.
struct Nearest {
  double distance = 0.0;       ///< signed distance, negative inside a closed surface; unsigned for an open one [m]
  Vec3 point = Vec3::Zero();   ///< nearest point on the surface [m]
  Vec3 normal = Vec3::Zero();  ///< outward unit normal at `point`
};

/// An immutable surface in its own frame O. The scene's Object holds its pose and motion.
class Surface {
 public:
  virtual ~Surface() = default;
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;

  /// Nearest point of the surface to any finite p [m]. The query does not allocate.
  [[nodiscard]] virtual Nearest nearest(const Vec3& p) const noexcept = 0;
  /// The same for callers that need exact distances only within `exact_within` [m]. Farther away the distance has the
  /// right sign and may be smaller than the true one, by a sixteenth and not below `exact_within`; the point may then
  /// be another one of the surface, and the normal is the direction away from it, towards the outside.
  [[nodiscard]] virtual Nearest nearest_or_far(const Vec3& p, double /*exact_within*/) const noexcept {
    return nearest(p);
  }
  /// This surface as a mesh, for methods that walk on triangles. Null for any other kind of surface.
  [[nodiscard]] virtual const Mesh* mesh() const noexcept { return nullptr; }
  /// The state of this surface if it deforms under the tool, for the loop that owns it; null for any other surface.
  [[nodiscard]] virtual Deformable* deformable() const noexcept { return nullptr; }
  /// False for a surface through noisy points. Noise turns its normals, so that a change of the stored energy without
  /// work is no jump, and the layer behind it may be nearer than the distance says, which is that of the nearest point.
  [[nodiscard]] virtual bool is_exact() const noexcept { return true; }
  /// Unique number of this surface, or of the stream of surfaces that it continues. Unlike an address, it is never used
  /// again.
  [[nodiscard]] std::uint64_t id() const noexcept { return id_; }

 protected:
  /// continues: id of the surface that this one replaces in the same stream; 0: a new number.
  explicit Surface(std::uint64_t continues = 0);

 private:
  std::uint64_t id_;
};

}  // namespace palpate::scene
