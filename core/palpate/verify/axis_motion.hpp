// The exact motion of a mass with dry friction between two events, for axis.hpp.
#pragma once

#include <array>

namespace palpate::verify {

/// M x'' = c - D x' - k (x - p - w t) - friction,   friction = Fc sign x'; at rest it balances the other forces up to
/// Fc.
class AxisMass {
 public:
  double x = 0.0, v = 0.0;  ///< [m], [m/s]

  /// M: mass [kg]; D: damping [N s/m]; k: stiffness [N/m]; Fc: dry friction [N].
  AxisMass(double M, double D, double k, double Fc) noexcept : M_(M), D_(D), k_(k), Fc_(Fc) {}
  /// Advances by h [s]. c: constant force [N]. The end of the spring is now at p [m] and moves at w [m/s].
  void step(double h, double c, double p, double w) noexcept;

 private:
  struct State {
    double x, v;
  };
  /// Transition matrix exp(A h) of the frictionless motion; for k = 0 of the velocity alone.
  struct Transition {
    double h = -1.0, xx = 1.0, xv = 0.0, vx = 0.0, vv = 1.0;
  };
  [[nodiscard]] Transition transition(double h) const noexcept;
  const Transition& remembered(double h) noexcept;
  [[nodiscard]] State free(const Transition& phi, double c, double p, double w) const noexcept;
  [[nodiscard]] double slip(double h, double c, double p, double w) noexcept;
  [[nodiscard]] double stick(double h, double c, double p, double w) noexcept;

  double M_, D_, k_, Fc_;
  int way_ = 0;  ///< sign of the velocity while the mass slips; 0 while it sticks
  std::array<Transition, 4> memory_;
  std::size_t oldest_ = 0;
};

}  // namespace palpate::verify
