// A simulated person who presses one place after another with a wanted force, by what the hand feels.
#pragma once

#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::network {

/// What is palpated, and how.
struct PalpationOptions {
  std::vector<Vec3> places;  ///< points clear of the surface, above the places to press, in W [m]
  double force = 1.0;        ///< wanted force [N]
  double within = 0.15;      ///< error of the force that counts as held, over the force [-]
  double hold = 0.4;         ///< time for which it is held [s]
  double speed = 0.06;       ///< of the hand's aim between places [m/s]
  double approach = 0.03;    ///< of the aim towards the surface [m/s]
  double gain = 0.02;        ///< speed of the aim per error of the force, at most `approach` [m/(N s)]
  double reaction = 0.15;    ///< the person acts on the force that was felt this long ago [s]
};

/// Moves the hand's aim: along -z until the surface is felt, on until the force is held, back up, and to the next
/// place. Without a link, the person returns to the place, waits there, and presses it anew.
class Palpation {
 public:
  /// Throws std::invalid_argument naming an invalid option.
  explicit Palpation(const PalpationOptions& options);
  /// One tick with the felt force F [N]; linked: the hand feels the remote side. Returns the aim of the hand [m].
  const Vec3& step(const Vec3& F, bool linked, double dt);
  /// True once all places were pressed and the aim is clear of the surface again.
  [[nodiscard]] bool done() const noexcept { return place_ >= options_.places.size(); }
  [[nodiscard]] const Vec3& aim() const noexcept { return aim_; }

 private:
  enum class Phase { move, down, press, up };
  bool approach(const Vec3& goal, double most) noexcept;
  double felt_then(double force, double dt);

  PalpationOptions options_;
  Phase phase_ = Phase::move;
  Vec3 aim_;
  std::size_t place_ = 0;
  double held_ = 0.0;
  std::vector<double> felt_;  ///< forces of the last ticks, as a ring [N]
  std::size_t next_ = 0;
};

}  // namespace palpate::network
