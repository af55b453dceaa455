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

/// The same for a field of forces that need not be the gradient of V: what E gains beyond the work of the hand against
/// the rendered force is summed up over the ticks, so that a small part in each tick counts as well.
class SpringAccount {
 public:
  /// As SpringRest::start().
  void start(double stored) noexcept {
    energy_ = most_ = stored;
    rest_ = unexplained_ = 0.0;
    share_ = 1.0;
  }
  /// V is changed by an edit, whose energy counts as put in; the rest stays. Returns the share of F that is rendered.
  double edit(double stored) noexcept {
    const double root = std::sqrt(std::max(stored, 0.0)), left = std::max(root - rest_, 0.0);
    return keep(root, left * left);
  }
  /// The share of F that is rendered [0-1].
  ///
  /// stored: V now. before, after: work of the hand since the last tick against the whole of F as it was then and as it
  /// is now. motion: energy that the motion of the surface has stored. inexact: part of the sum that is forgiven in
  /// this tick, as errors of the trapezoidal rule. All in one unit, for example [J].
  double step(double stored, double before, double after, double motion, double inexact) noexcept {
    const double root = std::sqrt(std::max(stored, 0.0)), left = std::max(root - rest_, 0.0);
    double energy = left * left, beyond = 0.0;
    for (int pass = 0; pass < kPasses; ++pass) {
      const double share = root > 0.0 ? std::sqrt(energy) / root : 1.0;
      const double work = 0.5 * (share_ * before + share * after) + share * motion;
      beyond = unexplained_ + energy - energy_ - work;
      beyond -= std::clamp(beyond, -inexact, inexact);
      const double slack = kSlack * std::max(most_, std::min(energy, energy_ + std::max(work, 0.0)));
      const double wanted = std::clamp(energy - (beyond - std::clamp(beyond, -slack, slack)), 0.0, root * root);
      beyond = std::max(beyond + wanted - energy, -slack);
      if (wanted == energy) break;
      energy = wanted;
    }
    unexplained_ = beyond;
    most_ = std::max(most_, energy);
    if (!(stored > 0.0)) unexplained_ = most_ = 0.0;  // a contact that has ended
    return keep(root, energy);
  }

 private:
  static constexpr double kSlack = 1e-3;  // of the largest E since the contact began, which may remain unexplained
  static constexpr int kPasses = 4;       // of the share within a tick, on which the work depends

  double keep(double root, double energy) noexcept {
    energy_ = energy;
    rest_ = std::max(root - std::sqrt(energy), 0.0);
    share_ = root > 0.0 ? 1.0 - rest_ / root : 1.0;
    return share_;
  }

  double energy_ = 0.0, rest_ = 0.0, share_ = 1.0;
  double unexplained_ = 0.0;  ///< what E has gained beyond the work of the hand
  double most_ = 0.0;         ///< largest E since the contact began
};

}  // namespace palpate
