// The exact motion of a mass with dry friction between two events; a part of verify/axis.
#pragma once

#include <array>

namespace palpate::verify {

/// M x'' = c - D x' - k (x - p - w t) - friction,   friction = Fc sign x', at rest whatever holds it up to Fc.
class AxisMass {
 public:
  double x = 0.0, v = 0.0;  ///< [m], [m/s]

  AxisMass(double M, double D, double k, double Fc) noexcept : M_(M), D_(D), k_(k), Fc_(Fc) {}
  /// h later. c: constant force [N]; the spring's end is at p now and moves at w [m], [m/s].
  void step(double h, double c, double p, double w) noexcept;

 private:
  struct State {
    double x, v;
  };
  /// exp(A h) of the free motion; for k = 0 that of the velocity alone.
  struct Transition {
    double h = -1.0, xx = 1.0, xv = 0.0, vx = 0.0, vv = 1.0;
  };
  [[nodiscard]] Transition transition(double h) const noexcept;
  const Transition& remembered(double h) noexcept;
  [[nodiscard]] State free(const Transition& phi, double c, double p, double w) const noexcept;
  [[nodiscard]] double slip(double h, double c, double p, double w) noexcept;
  [[nodiscard]] double stick(double h, double c, double p, double w) noexcept;

  double M_, D_, k_, Fc_;
  int way_ = 0;  ///< sign of the velocity while it slips; 0: it sticks
  std::array<Transition, 4> memory_;
  std::size_t oldest_ = 0;
};

}  // namespace palpate::verify
