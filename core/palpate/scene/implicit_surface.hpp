// The surface of the paper's Eqs 14-16: {x : U(x) = level} with U = a x1^m + b x2^n + c x3^o, normal grad U / |grad U|.
//
// Positive coefficients and even exponents: ellipsoids and pillows, which are convex, so that the nearest place is one.
#pragma once

#include <array>

#include "palpate/scene/surface.hpp"

namespace palpate::scene {

class ImplicitSurface final : public Surface {
 public:
  /// coefficients (a, b, c) > 0 [m^-m, m^-n, m^-o], exponents (m, n, o) even, 2 to 12; level > 0 [-].
  /// Throws std::invalid_argument naming what is wrong.
  ImplicitSurface(const Vec3& coefficients, const std::array<int, 3>& exponents, double level);

  [[nodiscard]] double value(const Vec3& p) const noexcept;   ///< U - level (Eq 14)
  [[nodiscard]] Vec3 gradient(const Vec3& p) const noexcept;  ///< psi = grad U (Eq 15) [1/m]
  /// Outside by Newton's method on the multiplier of the nearest-point problem, kept in a bracket; inside the best of a
  /// few local ones. Exact to rounding outside.
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  /// Half of its size along each axis [m].
  [[nodiscard]] const Vec3& half() const noexcept { return half_; }

 private:
  [[nodiscard]] Vec3 from_outside(const Vec3& p) const noexcept;
  [[nodiscard]] Vec3 from_inside(const Vec3& p) const noexcept;
  [[nodiscard]] double along(int axis, double p, double multiplier) const noexcept;
  [[nodiscard]] Vec3 towards(const Vec3& p, const Vec3& direction) const noexcept;
  bool settle(const Vec3& p, Vec3& x) const noexcept;
  void finish(const Vec3& p, Vec3& x) const noexcept;

  Vec3 coefficient_, half_;
  std::array<int, 3> exponent_;
  double level_;
};

}  // namespace palpate::scene
