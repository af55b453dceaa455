// The surface of the paper's Eqs 14-16: {x : U(x) = level} with U = a x1^m + b x2^n + c x3^o and the normal grad U /
// |grad U|.
//
// The coefficients are positive and the exponents even. The bodies are ellipsoids and pillows. They are convex, so
// every point outside has exactly one nearest point.
#pragma once

#include <array>

#include "palpate/scene/surface.hpp"

namespace palpate::scene {

/// Surface U(x) = level. All vectors are expressed in the surface's frame O.
class ImplicitSurface final : public Surface {
 public:
  /// coefficients: (a, b, c) > 0 [m^-m, m^-n, m^-o]; exponents: (m, n, o), even, 2 to 12; level: above 0 [-]. Throws
  /// std::invalid_argument with the reason.
  ImplicitSurface(const Vec3& coefficients, const std::array<int, 3>& exponents, double level);

  [[nodiscard]] double value(const Vec3& p) const noexcept;   ///< U - level at p (Eq 14) [-]
  [[nodiscard]] Vec3 gradient(const Vec3& p) const noexcept;  ///< psi = grad U at p (Eq 15) [1/m]
  /// Outside, Newton's method solves for the multiplier of the nearest-point problem within a bracket; the result is
  /// exact up to rounding. Inside, the result is the best of a few local solutions.
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  /// Half of the surface's size along each axis [m].
  [[nodiscard]] const Vec3& half() const noexcept { return half_; }

 private:
  [[nodiscard]] Vec3 from_outside(const Vec3& p) const noexcept;
  [[nodiscard]] Vec3 from_inside(const Vec3& p) const noexcept;
  [[nodiscard]] double solve_axis(int axis, double p, double multiplier) const noexcept;
  [[nodiscard]] Vec3 intersect_ray(const Vec3& p, const Vec3& direction) const noexcept;
  bool project_iteratively(const Vec3& p, Vec3& x) const noexcept;
  void refine(const Vec3& p, Vec3& x) const noexcept;

  Vec3 coefficient_, half_;
  std::array<int, 3> exponent_;
  double level_;
};

}  // namespace palpate::scene
