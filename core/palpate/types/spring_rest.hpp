// Where a spring begins: it stores no more than what the hand has put in, wherever its surface jumps.
#pragma once

#include <algorithm>
#include <cmath>

namespace palpate {

/// A spring that follows a surface is the gradient of an energy V, but the surface that it follows may jump: to other
/// triangles of a mesh, to the other side of a fixture. V then jumps as well, and a jump upwards would be energy that
/// the hand has not put in. The spring keeps the energy E that it had, and its rest is displaced instead:
///
///   E = (sqrt V - r)^2,     share s = dE/dV = 1 - r / sqrt V,     the force is s F for F = -grad V.
///
/// A spring of constant stiffness keeps the size of its force in such a jump. The rest r is zero until the first jump
/// upwards; jumps downwards, and a contact that ends, undo it.
class SpringRest {
 public:
  /// The contact begins, or what it stores was changed by an edit: `stored` counts as put in.
  void start(double stored) noexcept {
    stored_ = stored;
    rest_ = 0.0;
  }
  /// The share of F that is rendered [0-1].
  ///
  /// stored: V now. least, most: bounds of the work of the hand against the whole of F since the last tick. inexact:
  /// a smaller difference from them is no jump. All in one unit, for example [J].
  double step(double stored, double least, double most, double inexact) noexcept {
    const double rise = stored - stored_, root = std::sqrt(stored);
    const bool jumps = rise < least - inexact || rise > most + inexact;
    const double without_jump = jumps ? std::max(stored_ + std::clamp(rise, least, most), 0.0) : stored;
    rest_ = std::max(root - std::max(std::sqrt(without_jump) - rest_, 0.0), 0.0);
    stored_ = stored;
    return root > 0.0 ? 1.0 - rest_ / root : 1.0;
  }

 private:
  double stored_ = 0.0, rest_ = 0.0;
};

}  // namespace palpate
