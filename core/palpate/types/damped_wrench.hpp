// A wrench with its damping: the value that flows from guidance through mapping and stability to torque.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// The wrench F - B v on a body that moves with velocity v. The damping is kept apart for a device that can render it
/// by itself (an admittance law), faster than a wrench computed from a measured velocity. B is zero for all others.
struct DampedWrench {
  Wrench F;               ///< everything but the damping [N, N m]
  Mat3 B = Mat3::Zero();  ///< damping of the translation [N s/m]

  /// The damping's part, -B v [N]; v [m/s].
  [[nodiscard]] Wrench damping(const Vec3& v) const noexcept { return {-B * v, Vec3::Zero()}; }
  /// F - B v.
  [[nodiscard]] Wrench total(const Vec3& v) const noexcept { return F + damping(v); }
};

}  // namespace palpate
