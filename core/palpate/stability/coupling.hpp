// A virtual coupling: spring and damper between the handle and the virtual tool that touches.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::stability {

struct CouplingOptions {
  double stiffness = 0.0;  ///< [N/m]; 0: none, the handle is the virtual tool
  double damping = 0.0;    ///< beside the spring [N s/m]
};

/// Colgate, Stanley and Brown (1995). The massless virtual tool is displaced by y from the handle; the surface, felt
/// stiffness K, answers F - K y where it would answer F to the handle itself. Both forces are one:
///
///   K_c y + B_c y' = F - K y       out = F - K y,  never against F (a surface does not pull)
///
/// stepped by its exact solution for an F held over the period. At rest out = F K_c / (K + K_c): springs in series.
/// With damping a ramp of F comes out earlier by K B_c / (K_c (K + K_c)).
class Coupling {
 public:
  /// dt [s]. Throws std::invalid_argument.
  Coupling(const CouplingOptions& options, double dt);
  /// K: felt stiffness along F [N/m]. A moment is changed in the proportion of the force.
  Wrench step(const Wrench& F, double K) noexcept;
  void reset() noexcept { y_.setZero(); }
  [[nodiscard]] double lag(double K) const noexcept;  ///< of a ramp; below zero: it leads [s]

 private:
  CouplingOptions options_;
  double dt_;
  Vec3 y_ = Vec3::Zero();
};

}  // namespace palpate::stability
