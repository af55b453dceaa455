// A fixture as the stage sees it: a one-sided constraint on the tool, and the force that enforces it.
#pragma once

#include <limits>

#include "palpate/guidance/geometry.hpp"
#include "palpate/types/so3.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// The tool at which a constraint is evaluated. All in W.
struct ToolQuery {
  Pose X_WT;                    ///< pose at which to evaluate: measured, or commanded
  Vec3 p_touch = Vec3::Zero();  ///< measured place of the tool tip, where it feels F_T_W [m]
  Vec3 F_T_W = Vec3::Zero();    ///< force of the touched environment on the tool [N]
  double stiffness = 0.0;       ///< of the touched environment along that force; 0 when unknown [N/m]
};

/// A one-sided constraint: satisfied while gap >= 0.
struct Constraint {
  /// Constraint value: negative by the amount of violation [m, or rad if rotational]; +inf when inactive.
  double gap = std::numeric_limits<double>::infinity();
  /// Gradient J of the gap with respect to the tool's pose: d gap = J.f . dp + J.t . rotation. A rotational constraint
  /// has |J.t| = 1, or less where its target direction is uncertain; its J.f exists because the target direction
  /// changes with the place.
  Wrench gradient;
  double gap_rate_of_fixture = 0.0;  ///< d(gap)/dt caused by the fixture's own motion [m/s, rad/s]
  Vec3 w_fixture = Vec3::Zero();     ///< angular velocity of the fixture [rad/s]
  Mat3 free = Mat3::Identity();      ///< projector on the directions in which the hand moves freely
  bool attracts = false;             ///< the tool is to be at the geometry (guide, orient, rcm), not away from it
  bool rotational = false;           ///< the gap is an angle
  double speed_limit = std::numeric_limits<double>::infinity();  ///< of the tool, at this place [m/s]

  /// Sets the gap's rate for a geometry whose motion carries the whole constraint along.
  void set_fixture_motion(const Query& query, const Vec3& p_WT) noexcept {
    gap_rate_of_fixture =
        -gradient.f.dot(query.velocity + query.spin.cross(p_WT - query.point)) - gradient.t.dot(query.spin);
    w_fixture = query.spin;
  }
  /// Amount by which the constraint is violated, 0 when it is satisfied [m, rad].
  [[nodiscard]] double violation() const noexcept { return gap < 0.0 ? -gap : 0.0; }
  /// Rate of the gap that a damper works against while the tool moves with V_WT [m/s, rad/s]. Of a rotational
  /// constraint only the rotation counts: damping J.f as well would be too hard, by the square of J.f.
  [[nodiscard]] double rate(const Twist& V_WT) const noexcept {
    return rotational ? gradient.t.dot(V_WT.w - w_fixture)
                      : gradient.f.dot(V_WT.v) + gradient.t.dot(V_WT.w) + gap_rate_of_fixture;
  }
};

/// The force of a law. All in W, on the tool.
struct ConstraintForce {
  Wrench F;               ///< [N, N m]
  Mat3 B = Mat3::Zero();  ///< anisotropic damping that F contains; a device may render it by itself [N s/m]
  Wrench F_of_B;          ///< the part of F that is - B v
  double U = 0.0;         ///< stored energy [J]
};

/// Length that makes a rotation of 1 rad comparable to a displacement [m].
inline constexpr double kLength = 0.05;

/// The constraint's gradient over (displacement, kLength * rotation). A rotational constraint is satisfied by rotating
/// the tool, never by moving it to a place with another target direction.
inline Vec6 row(const Constraint& c) noexcept {
  Vec6 a;
  a << (c.rotational ? Vec3(Vec3::Zero()) : c.gradient.f), c.gradient.t / kLength;
  return a;
}

/// Position difference and scaled rotation vector from X_a to X_b.
inline Vec6 displacement(const Pose& X_a, const Pose& X_b) noexcept {
  Vec6 y;
  y << X_b.p - X_a.p, kLength * rotation_vector(X_b.R * X_a.R.transpose());
  return y;
}

/// X displaced by y: the inverse of displacement().
inline Pose displaced(const Pose& X, const Vec6& y) noexcept {
  const Vec3 theta = y.tail<3>() / kLength;
  const double angle = theta.norm();
  return {angle > 0.0 ? Mat3(Eigen::AngleAxisd(angle, theta / angle) * X.R) : X.R, X.p + y.head<3>()};
}

}  // namespace palpate::guidance
