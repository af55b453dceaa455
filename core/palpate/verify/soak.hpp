// Soak: very many short random pokes at one mesh, judged by a second algorithm, to show that nothing pops through.
//
// A pass comes from free space at a random place of the surface, under a random angle, goes up to `depth` beyond it
// and is dragged on; the tool moves, or the object against the resting tool, or both. The judge knows no hierarchy:
// wherever the proxy goes, within a tick and from one to the next, in the object's frame, it must not cross a triangle.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "palpate/contact/contact.hpp"
#include "palpate/scene/mesh.hpp"

namespace palpate::verify {

/// How to poke; each pass draws its own values from these ranges.
struct SoakRange {
  double radius_min = 0.5e-3, radius_max = 4e-3;  ///< SPR [m]
  double speed_min = 0.1, speed_max = 1.0;        ///< of the tool [m/s]
  double depth = 20e-3;                           ///< beyond the surface, at most [m]
  double drag = 10e-3;                            ///< afterwards, in any direction, at most [m]
  double angle = 1.4;                             ///< from the normal, at most [rad]
  double object_speed = 0.5;                      ///< of the object, at most [m/s]
};

/// One pass, as it was drawn.
struct SoakPass {
  std::int64_t index = -1;
  double radius = 0.0, speed = 0.0, depth = 0.0;  ///< [m], [m/s], [m]
  bool object_moves = false;
};

struct SoakReport {
  std::int64_t passes = 0;  ///< that found free space to begin in
  std::int64_t ticks = 0;
  std::int64_t touched = 0;  ///< passes with a force
  std::int64_t popped = 0;   ///< passes whose proxy crossed the surface
  SoakPass first_popped;
};

/// `passes` at 1 kHz with the named method. Throws std::invalid_argument for an unknown one.
SoakReport soak(const std::shared_ptr<const scene::Mesh>& mesh, std::string_view method, std::int64_t passes,
                std::uint64_t seed, const SoakRange& range);

}  // namespace palpate::verify
