// A wrench with a separate damping term: the value passed from guidance through mapping and stability to torque.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// The wrench F - B v on a body that moves with velocity v. The damping is separate for devices that render damping
/// themselves (admittance law): their internal loop is faster than a wrench computed from a measured velocity. For all
/// other devices B is zero.
struct DampedWrench {
  Wrench F;               ///< wrench without the damping [N, N m]
  Mat3 B = Mat3::Zero();  ///< translational damping [N s/m]

  /// Damping wrench: force -B v [N] and no moment; v [m/s].
  [[nodiscard]] Wrench damping(const Vec3& v) const noexcept { return {-B * v, Vec3::Zero()}; }
  /// Total wrench F - B v [N, N m]; v [m/s].
  [[nodiscard]] Wrench total(const Vec3& v) const noexcept { return F + damping(v); }
};

}  // namespace palpate
