// The world at one instant: immutable, swapped whole, never edited.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "palpate/scene/material.hpp"
#include "palpate/scene/motion.hpp"
#include "palpate/scene/surface.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// Objects of a snapshot, at most.
inline constexpr int kMaxObjects = 32;

struct Object {
  std::string name;
  std::shared_ptr<const Surface> surface;  ///< in the object's frame O [m]
  Pose X_WO;                               ///< at rest
  Material material;
  std::vector<Region> regions;  ///< where it feels otherwise; a later one lies over an earlier one
  Motion motion;
  bool is_virtual = true;  ///< the contact stage feels it
  bool is_real = true;     ///< the tool of a driven follower bumps into it

  /// Where it is at time t [s].
  [[nodiscard]] Pose pose(double t) const noexcept { return motion.pose(X_WO, t); }
  /// How it feels at p_O, in its frame.
  [[nodiscard]] Feel feel(const Vec3& p_O) const noexcept {
    Feel out{material};
    for (const Region& region : regions) out.blend(region, p_O);
    return out;
  }
};

struct Snapshot {
  std::vector<Object> objects;
};

}  // namespace palpate::scene
