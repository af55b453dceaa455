// Place, stiffness, damping and friction of a touched object, estimated from the motion and the force of the tool.
#pragma once

#include <array>
#include <cmath>

#include "palpate/network/packet.hpp"
#include "palpate/scene/surface.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::network {

/// Distance of p_O to a surface, negative behind it: an open surface has no inside, but its normals have a side.
[[nodiscard]] inline double signed_distance(const scene::Nearest& c, const Vec3& p_O) noexcept {
  return std::copysign(c.distance, (p_O - c.point).dot(c.normal));
}

/// What is known before the first touch, and how the sensor errs.
struct EstimatorOptions {
  double K = 300.0;          ///< assumed stiffness [N/m]
  double sd_K = 300.0;       ///< its standard deviation [N/m]
  double sd_place = 0.002;   ///< standard deviation of the object's place along each axis [m]
  double sd_force = 0.02;    ///< noise of the measured force [N]
  double sd_model = 0.01;    ///< error of the linear law, as a share of the force [-]
  double most_shift = 0.03;  ///< largest displacement that is believed [m]
  double sd_along = -1.0;    ///< standard deviation of the place along `normal`; negative: as the others [m]
  Vec3 normal = Vec3::UnitZ();
};

/// One measurement: where the tool is relative to the object of the scene, and what it feels. All vectors in W.
struct Touch {
  double depth = 0.0;          ///< of the tool's sphere below the surface as the scene has it; negative outside [m]
  Vec3 normal = Vec3::Zero();  ///< outward normal at the nearest point
  Vec3 v = Vec3::Zero();       ///< velocity of the tool relative to the surface [m/s]
  Vec3 F = Vec3::Zero();       ///< measured force on the tool [N]
};

/// Directions across the normal.
inline constexpr int kAcross = 2;

/// Parameters of an object for which a contact is computed.
struct Guess {
  Vec3 shift = Vec3::Zero();  ///< displacement from its place in the scene, in W [m]
  double K = 0.0;             ///< stiffness [N/m]
};

/// Forces on the tool, in W, by the contact with the object as estimated and as it would be with perturbed estimates.
struct Prediction {
  bool touching = false;                   ///< true while the tool touches the object as estimated
  bool across = false;                     ///< true in ticks in which all have a contact; otherwise only F is valid
  Vec3 F = Vec3::Zero();                   ///< of the estimate [N]
  std::array<Vec3, kAcross> above, below;  ///< of Estimator::guess(j, 1) and guess(j, -1) [N]
  Vec3 per_mu = Vec3::Zero();              ///< change of F with friction [N]
  Vec3 bend = Vec3::Zero();                ///< difference of that change between more and less friction [N]
};

/// The force along the normal n is linear in theta = (K, K shift, B):
///
///   F . n = K depth + (K shift) . n - B v . n
///
/// so a Kalman filter with a slow random walk of theta is the exact minimum-variance estimate. Across the normal the
/// force depends on the slope of the surface at the tool, on friction, and on where the tool has begun to stick. No
/// formula tells this, but the contact itself does: it is computed for the estimate and for estimates that lie one
/// standard deviation aside, and the differences of their forces replace the derivatives (the divided difference filter
/// of Noergaard, Poulsen and Ravn 2000). Where the tool sticks, these forces do not depend on friction, so sticking
/// tells nothing about it. Without a measured force where the estimate says contact, the surface is no nearer than the
/// tool, which bounds its place alone. If the innovation along the normal exceeds its standard deviation kSurprise
/// times for kSurprised ticks, the object has moved: the place becomes unknown again.
///
/// Slopes that are taken at a wrong place lead farther away. What tells it is a force that points elsewhere: it lowers
/// the weight of the force along the normal, and makes the place across it uncertain again. An estimate that leaves
/// most of the force unexplained begins anew.
class Estimator {
 public:
  explicit Estimator(const EstimatorOptions& options);
  /// One tick; true if it has told something about the object. prediction: by the guesses since the last tick.
  bool step(const Touch& touch, const Prediction& prediction = {}) noexcept;
  /// The estimate, perturbed along the tangent j of the last normal: side 1 or -1; 0: not perturbed.
  [[nodiscard]] Guess guess(int j, int side) const noexcept;
  /// The estimate; `object` is left as it is.
  [[nodiscard]] ModelEstimate estimate() const noexcept;
  /// The place becomes less certain: variances along the last normal and across it grow [m^2].
  void wander(double along, double across) noexcept;
  /// Makes the present place the new origin of the shift, which becomes zero; returns the shift until now [m].
  Vec3 recentre() noexcept;
  /// Turns the covariance of the place with the object.
  void turn(const Mat3& R) noexcept;
  /// Standard deviation of the friction coefficient [-].
  [[nodiscard]] double sd_mu() const noexcept { return std::sqrt(std::max(P_(5, 5), 0.0)); }
  /// Force along the normal that the estimate predicts, at least 0 [N].
  [[nodiscard]] double predicted(const Touch& touch) const noexcept;
  /// Number of times that the object was found moved, or the estimate lost.
  [[nodiscard]] int moved() const noexcept { return moved_; }

 private:
  static constexpr int kN = 6;  ///< K, K shift (3), B, mu
  using Vec = Eigen::Matrix<double, kN, 1>;
  using Mat = Eigen::Matrix<double, kN, kN>;
  /// One standard deviation of the estimate along one direction, and which part of it the guesses lie aside.
  struct Column {
    Vec sd = Vec::Zero();
    double part = 0.0;
  };
  [[nodiscard]] static Vec row(const Touch& touch) noexcept;
  void begin() noexcept;
  [[nodiscard]] bool lost(const Touch& touch, const Prediction& prediction, double prior) noexcept;
  void forget_place() noexcept;
  void reopen(const Vec3& normal) noexcept;
  void recede(const Vec3& normal, double prior) noexcept;
  void measure(const Vec& h, double innovation, double sd) noexcept;
  void learn_across(const Touch& touch, const Prediction& prediction) noexcept;
  void spread() noexcept;
  void bound() noexcept;

  EstimatorOptions options_;
  Vec theta_;
  Mat P_;
  Vec3 normal_ = Vec3::UnitZ();             ///< last touched normal
  std::array<Column, kAcross + 1> column_;  ///< the last one: friction
  double residual2_ = 0.0;
  double contradiction_ = 0.0;  ///< force across the normal that the estimate does not explain, above its noise [N]
  int surprised_ = 0, moved_ = 0, rest_ = 0, contradicted_ = 0, lost_ = 0;
};

}  // namespace palpate::network
