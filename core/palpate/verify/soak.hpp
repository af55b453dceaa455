// Soak test: a large number of short random passes of a tool into a mesh, which show that the proxy never passes
// through the surface. A second algorithm checks the result.
//
// In a pass the tool comes from free space, meets a random point of the surface at a random angle, goes up to `depth`
// beyond it and is dragged on. The tool moves, or the object moves against the resting tool, or both move. The check
// uses no bounding-volume hierarchy: the path of the proxy in the object's frame, within a tick and between ticks, must
// not cross any triangle.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "palpate/contact/contact.hpp"
#include "palpate/scene/mesh.hpp"

namespace palpate::verify {

/// Ranges from which each pass draws its values.
struct SoakRange {
  double radius_min = 0.5e-3, radius_max = 4e-3;  ///< radius of the spherical proxy region (SPR) [m]
  double speed_min = 0.1, speed_max = 1.0;        ///< speed of the tool [m/s]
  double depth = 20e-3;                           ///< largest depth beyond the surface [m]
  double drag = 10e-3;                            ///< longest motion afterwards, in any direction [m]
  double angle = 1.4;                             ///< largest angle from the normal [rad]
  double object_speed = 0.5;                      ///< largest speed of the object [m/s]
};

/// Drawn values of one pass.
struct SoakPass {
  std::int64_t index = -1;
  double radius = 0.0, speed = 0.0, depth = 0.0;  ///< [m], [m/s], [m]
  bool object_moves = false;
};

/// Result of a soak test.
struct SoakReport {
  std::int64_t passes = 0;  ///< passes that began in free space
  std::int64_t ticks = 0;
  std::int64_t touched = 0;  ///< passes with a contact
  std::int64_t crossed = 0;  ///< passes whose proxy crossed the surface
  SoakPass first_crossed;    ///< the first of them
};

/// Runs `passes` passes at 1 kHz with the named contact method. Throws std::invalid_argument for an unknown method.
SoakReport soak(const std::shared_ptr<const scene::Mesh>& mesh, std::string_view method, std::int64_t passes,
                std::uint64_t seed, const SoakRange& range);

}  // namespace palpate::verify
