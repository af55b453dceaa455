// The world at one instant: immutable, swapped whole, never edited.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "palpate/scene/surface.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// How an object feels. Diagonal stiffness and damping along the axes of W (Eq 8).
struct Material {
  Vec3 K = Vec3::Constant(500.0);  ///< stiffness [N/m]
  Vec3 B = Vec3::Constant(0.0);    ///< damping [N s/m]
  double mu = 0.0;                 ///< Coulomb friction coefficient [-]
};

struct Object {
  std::string name;
  std::shared_ptr<const Surface> surface;  ///< in the object's frame O [m]
  Pose X_WO;
  Material material;
};

struct Snapshot {
  std::vector<Object> objects;
};

}  // namespace palpate::scene
