// The near field of a contact: the force of a sphere that indents a half-space, less what the mesh already yields.
//
//   F(d) = 4/3 E* sqrt(R) d^1.5 (1 + (g - 1 / 10) x - x^2 / 840 + 11 x^3 / 15120),    x = d / R <= 1
//
// The force is that of Hertz with the series for the true shape of a sphere (Sneddon 1965, Mueller and others 2019). A
// Neo-Hookean half-space departs from it by less than 7 % up to d = R (palpate_lab.verify.tissue). The growth g says
// how the modulus changes with depth. Beyond x = 1 the force goes on as a power of x with the same slope. A body that
// yields by C F under a smooth load of the same size leaves the depth delta = d - C F(d) to the sphere, so that near
// and far field add up. The tangent of delta keeps at least the share kLeast, where the contact is about as wide as the
// load.
#pragma once

#include <algorithm>
#include <cmath>

namespace palpate::tissue {

/// Force and energy of a sphere at one contact point.
class LocalLaw {
 public:
  /// plane_modulus: E* = E / (1 - nu^2) [Pa]; radius: of the sphere [m]; compliance: of the body under the load [m/N];
  /// growth: relative change of the secant modulus at the depth of a radius, at least -.1 [-].
  LocalLaw(double plane_modulus, double radius, double compliance, double growth = 0.0) noexcept
      : scale_(4.0 / 3.0 * plane_modulus * radius * radius),
        radius_(radius),
        compliance_(compliance),
        a_(growth - 0.1),
        one_(1.0 + a_ + kB + kC),
        power_((1.5 + 2.5 * a_ + 3.5 * kB + 4.5 * kC) / one_) {
    double low = 0.0, high = 64.0;  // [radius] depth at which the tangent reaches its least share
    if (compliance_ * slope(high) > 1.0 - kLeast)
      for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (low + high);
        (compliance_ * slope(middle) > 1.0 - kLeast ? high : low) = middle;
      }
    limit_ = high;
  }

  /// Values at the depth delta of the sphere below the surface of the body.
  struct Value {
    double force = 0.0;    ///< [N]
    double tangent = 0.0;  ///< d force / d delta [N/m]
    double stored = 0.0;   ///< integral of the force over delta [J]
    double yield = 0.0;    ///< what the body gives way: d - delta [m]
    double kept = 0.0;     ///< energy that the body stores: integral of the force over d, less `stored` [J]
  };
  [[nodiscard]] Value at(double delta) const noexcept {
    if (!(delta > 0.0)) return {};
    double x = delta / radius_;
    for (int i = 0; i < 8; ++i) x += std::max(delta - remaining(x), 0.0) / (radius_ * share(x));
    const double F = force(x), yield = x * radius_ - delta;
    if (x <= limit_) {
      const double kept = 0.5 * compliance_ * F * F;
      return {F, slope(x) / share(x), energy(x) - kept, yield, kept};
    }
    const double F_limit = force(limit_), more = energy(x) - energy(limit_);
    const double kept = 0.5 * compliance_ * F_limit * F_limit + (1.0 - kLeast) * more;
    return {F, slope(x) / kLeast, energy(x) - kept, yield, kept};
  }
  /// Values at a depth delta below a surface that was last computed when the body had given way by `yield` [m] and had
  /// stored `kept` [J]: until it is computed again, the body gives way as the half-space does.
  [[nodiscard]] Value since(double delta, double yield, double kept) const noexcept {
    if (!(delta > 0.0)) return {};
    const double x = (delta + yield) / radius_;
    return {force(x), slope(x), std::max(energy(x) - kept, 0.0), yield, kept};
  }

 private:
  static constexpr double kLeast = 0.2;                            // share of the tangent of delta
  static constexpr double kB = -1.0 / 840.0, kC = 11.0 / 15120.0;  // of the series in x

  [[nodiscard]] double force(double x) const noexcept {
    return scale_ * (x <= 1.0 ? x * std::sqrt(x) * (1.0 + x * (a_ + x * (kB + x * kC))) : one_ * std::pow(x, power_));
  }
  [[nodiscard]] double slope(double x) const noexcept {  // dF / dd [N/m]
    return scale_ / radius_ *
           (x <= 1.0 ? std::sqrt(x) * (1.5 + x * (2.5 * a_ + x * (3.5 * kB + x * 4.5 * kC)))
                     : power_ * one_ * std::pow(x, power_ - 1.0));
  }
  [[nodiscard]] double energy(double x) const noexcept {  // integral of F over d [J]
    const auto series = [this](double y) {
      return y * y * std::sqrt(y) * (1.0 / 2.5 + y * (a_ / 3.5 + y * (kB / 4.5 + y * kC / 5.5)));
    };
    return scale_ * radius_ *
           (x <= 1.0 ? series(x) : series(1.0) + one_ / (power_ + 1.0) * (std::pow(x, power_ + 1.0) - 1.0));
  }
  /// d delta / dd.
  [[nodiscard]] double share(double x) const noexcept {
    return x > limit_ ? kLeast : std::max(1.0 - compliance_ * slope(x), kLeast);
  }
  /// delta at d = x R [m].
  [[nodiscard]] double remaining(double x) const noexcept {
    const double y = std::min(x, limit_);
    return radius_ * y - compliance_ * force(y) + kLeast * radius_ * (x - y);
  }

  double scale_, radius_, compliance_;
  double a_;            // of the series in x
  double one_, power_;  // the series at x = 1, and the power beyond
  double limit_ = 64.0;
};

}  // namespace palpate::tissue
