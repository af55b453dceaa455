// A fixture as the stage sees it: a one-sided constraint on the tool, and the force that enforces it.
#pragma once

#include <cmath>
#include <limits>

#include "palpate/guidance/geometry.hpp"
#include "palpate/types/so3.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::guidance {

/// State of the tool for which a constraint is evaluated, in W.
struct ToolQuery {
  Pose X_WT;                    ///< pose at which the constraint is evaluated: measured or commanded
  Vec3 p_touch = Vec3::Zero();  ///< measured position of the tool tip, where F_T_W acts [m]
  Vec3 F_T_W = Vec3::Zero();    ///< force of the touched environment on the tool [N]
  double stiffness = 0.0;       ///< stiffness of the environment along that force; 0 when unknown [N/m]
};

/// A one-sided constraint: satisfied while gap >= 0.
struct Constraint {
  /// Constraint value: negative by the amount of violation [m, or rad if rotational]; +inf when inactive.
  double gap = std::numeric_limits<double>::infinity();
  /// Gradient J of the gap with respect to the tool's pose: d gap = J.f . dp + J.t . rotation. A rotational constraint
  /// has |J.t| = 1, or less where its target direction is uncertain. Its J.f is not zero where the target direction
  /// changes with the position.
  Wrench gradient;
  double gap_rate_of_fixture = 0.0;  ///< d(gap)/dt caused by the fixture's own motion [m/s, rad/s]
  Vec3 w_fixture = Vec3::Zero();     ///< angular velocity of the fixture [rad/s]
  Mat3 free = Mat3::Identity();      ///< projector on the directions in which the hand moves freely
  bool attracts = false;    ///< true: draws the tool to a target (guide, orient, rcm); false: keeps it behind a border
  bool rotational = false;  ///< the gap is an angle
  bool by_force = false;  ///< the border is where the touched force reaches its limit, so that force stays on the hand
  double speed_limit = std::numeric_limits<double>::infinity();  ///< largest speed of the tool here [m/s]

  /// Sets gap_rate_of_fixture and w_fixture for a constraint that moves rigidly with its geometry.
  void set_fixture_motion(const Query& query, const Vec3& p_WT) noexcept {
    gap_rate_of_fixture =
        -gradient.f.dot(query.velocity + query.spin.cross(p_WT - query.point)) - gradient.t.dot(query.spin);
    w_fixture = query.spin;
  }
  /// True if the constraint has a gap and a gradient, so that it can be a row of a program.
  [[nodiscard]] bool one_sided() const noexcept {
    return std::isfinite(gap) && (gradient.f != Vec3::Zero() || gradient.t != Vec3::Zero());
  }
  /// Amount by which the constraint is violated, 0 when it is satisfied [m, rad].
  [[nodiscard]] double violation() const noexcept { return gap < 0.0 ? -gap : 0.0; }
  /// Rate of the gap on which a damper acts while the tool moves with V_WT [m/s, rad/s]. For a rotational constraint
  /// only the rotation counts: damping along J.f as well would be too strong, because it grows with |J.f|^2.
  [[nodiscard]] double rate(const Twist& V_WT) const noexcept {
    return rotational ? gradient.t.dot(V_WT.w - w_fixture)
                      : gradient.f.dot(V_WT.v) + gradient.t.dot(V_WT.w) + gap_rate_of_fixture;
  }
};

/// Wrench of a law on the tool, in W.
struct ConstraintForce {
  Wrench F;               ///< whole wrench, including the damping [N, N m]
  Mat3 B = Mat3::Zero();  ///< anisotropic damping that F contains, for a device that renders it by itself [N s/m]
  Wrench F_of_B;          ///< the part of F that B causes [N, N m]
  double U = 0.0;         ///< stored energy [J]
};

/// Scales a force by an authority.
inline void scale(ConstraintForce& force, double by) noexcept {
  force.F = {by * force.F.f, by * force.F.t};
  force.F_of_B.f *= by;
  force.B *= by;
  force.U *= by;
}

/// Length that makes a rotation of 1 rad comparable to a displacement [m].
inline constexpr double kLength = 0.05;

/// Gradient of the gap with respect to (displacement, kLength * rotation), for the quadratic program. A rotational
/// constraint has no translational part: it is satisfied by rotating the tool, never by moving it to a position with
/// another target direction.
inline Vec6 row(const Constraint& c) noexcept {
  Vec6 a;
  a << (c.rotational ? Vec3(Vec3::Zero()) : c.gradient.f), c.gradient.t / kLength;
  return a;
}

/// Displacement from X_a to X_b: position difference, and rotation vector times kLength [m].
inline Vec6 displacement(const Pose& X_a, const Pose& X_b) noexcept {
  Vec6 y;
  y << X_b.p - X_a.p, kLength * rotation_vector(X_b.R * X_a.R.transpose());
  return y;
}

/// X displaced by y: the inverse of displacement().
inline Pose displaced(const Pose& X, const Vec6& y) noexcept {
  return {rotation_by(y.tail<3>() / kLength) * X.R, X.p + y.head<3>()};
}

}  // namespace palpate::guidance
