// A virtual coupling: a spring and a damper between the handle and the virtual tool that touches the surfaces.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate::stability {

/// Options of the virtual coupling.
struct CouplingOptions {
  double stiffness = 0.0;  ///< stiffness K_c [N/m]; 0: no coupling, the handle is the virtual tool
  double damping = 0.0;    ///< damping B_c in parallel with the spring [N s/m]
};

/// Virtual coupling after Colgate, Stanley and Brown (1995). The massless virtual tool is displaced by y from the
/// handle. A surface of felt stiffness K would exert F on a tool at the handle; it exerts F - K y on the virtual tool.
/// Coupling and surface are in equilibrium:
///
///   K_c y + B_c y' = F - K y       out = F - K y,  never against F, because a surface does not pull
///
/// The step uses the exact solution for an F that is held over the period. At rest out = F K_c / (K + K_c), as of
/// springs in series. With damping a ramp of F comes out earlier by K B_c / (K_c (K + K_c)).
class Coupling {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an invalid option.
  Coupling(const CouplingOptions& options, double dt);
  /// One tick. F: wrench on the hand. K: felt stiffness along F [N/m]. A moment is scaled as the force is.
  Wrench step(const Wrench& F, double K) noexcept;
  void reset() noexcept { y_.setZero(); }
  /// Lag of a ramp of force [s]; negative: the output leads.
  [[nodiscard]] double lag(double K) const noexcept;

 private:
  CouplingOptions options_;
  double dt_;
  Vec3 y_ = Vec3::Zero();
};

}  // namespace palpate::stability
