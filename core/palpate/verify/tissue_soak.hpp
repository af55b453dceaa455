// Soak test of a soft body: a large number of random pokes, slides and grasps one after another on the same body, with
// checks that the force stays finite, no tool pops through, and the tissue returns to rest without inverted tetrahedra.
#pragma once

#include <cstdint>

#include "palpate/tissue/soft_surface.hpp"

namespace palpate::verify {

/// Ranges from which each action draws its values.
struct TissueSoakRange {
  double radius = 5e-3;                         ///< radius of both spheres of the tool [m]
  double speed_min = 0.05, speed_max = 1.0;     ///< speed of the tool [m/s]
  double depth = 0.03;                          ///< longest way below the surface [m]
  double force_min = 0.3, force_max = 3.0;      ///< force at which the tool turns back [N]
  double hard_share = 0.02, hard_force = 20.0;  ///< share of the actions that go on up to this force [-], [N]
  double friction = 1.0;                        ///< largest coefficient of friction [-]
  int rest_every = 25;                          ///< actions between two checks at rest
  double rest = 0.6;                            ///< time without contact before such a check [s]
  double hold = 0.25;                           ///< time for which a poke is held where it turns back [s]
  double restless = 5e-3;  ///< second difference of the force that is no rest, unless the swing decays [N]
  double decay = 0.9;      ///< kinetic energy over that of the third of the hold before, below which it does [-]
};

/// Result of a soak test.
struct TissueSoakReport {
  std::int64_t pokes = 0, slides = 0, grasps = 0;  ///< actions of each kind, hard ones included
  std::int64_t hard = 0;                           ///< actions beyond force_max
  std::int64_t touched = 0;                        ///< actions with a contact
  std::int64_t ticks = 0;
  std::int64_t held = 0;              ///< pokes that were held in contact
  std::int64_t restless = 0;          ///< of these with a force that neither rested nor swung out, up to force_max
  std::int64_t not_finite = 0;        ///< actions with a force that is not finite
  std::int64_t popped = 0;            ///< actions in which a sphere lost its contact below the surface
  std::int64_t guarded = 0;           ///< actions up to force_max in which the guard stopped a divergence
  std::int64_t guarded_hard = 0;      ///< the same, of the hard actions
  std::int64_t hurried = 0;           ///< actions in which the body took more steps because it moved fast
  std::int64_t rests = 0;             ///< checks at rest
  std::int64_t inverted_at_rest = 0;  ///< checks with an inverted tetrahedron
  std::int64_t moved_at_rest = 0;     ///< checks with a node farther than a tenth of an edge from its place
  double least_volume = 1.0;          ///< smallest det F in an action [-]
  double least_volume_at_rest = 1.0;  ///< the same at rest [-]
  double largest_force = 0.0;         ///< of the actions up to force_max [N]
};

/// Runs `actions` actions at 1 kHz on a copy at rest of a surface, whose nodes below the height `held_below` [m] are
/// held and not touched. The same seed gives the same actions.
TissueSoakReport soak_tissue(const tissue::SoftSurface& surface, std::int64_t actions, std::uint64_t seed,
                             double held_below, const TissueSoakRange& range);

}  // namespace palpate::verify
