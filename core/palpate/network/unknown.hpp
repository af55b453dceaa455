// A touched surface that the scene does not have: the plane below the tool, estimated from its motion and force.
#pragma once

#include "palpate/network/copies.hpp"
#include "palpate/network/estimator.hpp"
#include "palpate/scene/snapshot.hpp"

namespace palpate::network {

/// Estimates the plane by the estimator of known objects, which sees the surface of a sphere of the radius kRound that
/// touches the plane below the tool: a displacement of the sphere along the normal is one of the plane, and one across
/// it tilts the plane by displacement / kRound. After each tick the sphere is turned about the tool and takes the
/// estimated place, so that both stay tangent there. The surface may bend, so that the plane is less certain with each
/// millimetre that the tool moves along it.
class Unknown {
 public:
  Unknown(const EstimatorOptions& options, double radius) : options_(options), radius_(radius) {}
  /// The object with that sphere, as the site's snapshot has it.
  [[nodiscard]] static scene::Object object(const EstimatorOptions& options);
  /// One tick before the estimator's: a force F [N] on the tool at p [m] that no known surface explains begins a plane;
  /// it ends where the tool is far from its last touch. known: true if a known surface may explain the force.
  void seek(const Vec3& p, const Vec3& F, bool known, scene::Object& object, Estimator& estimator,
            Copies& copies) noexcept;
  /// One tick after it: the object takes the estimated place.
  void follow(const Vec3& p, const Vec3& F, scene::Object& object, Estimator& estimator, Copies& copies) noexcept;
  /// True while there is a plane.
  [[nodiscard]] bool exists() const noexcept { return exists_; }
  /// Adds place and normal of the plane below the tool to an estimate.
  void describe(ModelEstimate& estimate, const scene::Object& object) const noexcept;

 private:
  static constexpr double kRound = 0.1;  ///< [m]
  EstimatorOptions options_;
  double radius_;  ///< of the tool [m]
  bool exists_ = false;
  int felt_ = 0;                                       ///< ticks with an unexplained force
  Vec3 touched_ = Vec3::Zero(), last_ = Vec3::Zero();  ///< tool at the last touch, and in the last tick with one [m]
};

}  // namespace palpate::network
