// The plane that the hand feels where the scene has no object: its pose approaches the estimate without a kick.
#pragma once

#include "palpate/network/estimator.hpp"
#include "palpate/network/model_update.hpp"
#include "palpate/scene/snapshot.hpp"

namespace palpate::network {

/// A plane turns about the centre of the tool's sphere, which changes neither its depth nor the energy of its springs,
/// and shifts along its normal as its ModelUpdate allows. Both together change the force by at most the force rate.
class LocalPlane {
 public:
  /// force_rate: largest change of the force by an update [N/s].
  explicit LocalPlane(double force_rate) : force_rate_(force_rate) {}
  /// The plane, out of reach until the first estimate arrives.
  [[nodiscard]] static scene::Object object();
  /// Share of the force rate that is left for shifts.
  static constexpr double kShiftShare = 0.8;
  /// One tick before the update's: turns the object, and sets goal.shift to where the update shall bring the plane,
  /// relative to the shift `now`. p: centre of the tool's sphere of this radius [m]; F: contact force on it [N].
  void aim(const Vec3& p, const Vec3& F, double radius, const Vec3& now, double dt, scene::Object& object,
           ModelEstimate& goal) noexcept;

 private:
  static constexpr double kTurnShare = 0.6;  ///< 0.6^2 + 0.8^2 = 1: both changes of the force are orthogonal
  double force_rate_;
  bool placed_ = false;
};

}  // namespace palpate::network
