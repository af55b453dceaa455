// What can be touched, whatever it is made of: one question, the same answer from meshes, primitives and fields.
#pragma once

#include <cstdint>

#include "palpate/types/spatial.hpp"

namespace palpate::scene {

class Mesh;

/// Nearest place of a surface to a point. In the surface's own frame O.
struct Nearest {
  double distance = 0.0;       ///< signed: below zero inside of a closed surface; unsigned when it is open [m]
  Vec3 point = Vec3::Zero();   ///< on the surface [m]
  Vec3 normal = Vec3::Zero();  ///< unit, outwards, at `point`
};

/// A surface at rest in its frame O; where it is and how it moves is the Object's.
class Surface {
 public:
  virtual ~Surface() = default;
  Surface(const Surface&) = delete;
  Surface& operator=(const Surface&) = delete;

  /// For any finite p [m]. Allocation free.
  [[nodiscard]] virtual Nearest nearest(const Vec3& p) const noexcept = 0;
  /// This surface as triangles, for methods that walk on them; null when it is none.
  [[nodiscard]] virtual const Mesh* mesh() const noexcept { return nullptr; }
  /// Of this very surface: an address may be used again, this number is not.
  [[nodiscard]] std::uint64_t id() const noexcept { return id_; }

 protected:
  Surface();

 private:
  std::uint64_t id_;
};

}  // namespace palpate::scene
