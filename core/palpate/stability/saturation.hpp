// The cap of the force as a spring that saturates: it never exceeds the cap, and no closed loop of the hand gains
// energy by it.
#pragma once

namespace palpate::stability {

/// The factor s by which a force F, the gradient of a potential U, is shortened to the cap. A force that is cut to its
/// length by itself is the gradient of no energy where the stiffness varies. The factor is therefore a function of the
/// energy alone,
///
///   s = min(1, sqrt(E / U)),     the energy left is S = U for U <= E, and 2 sqrt(E U) - E beyond,
///
/// which holds the force of a spring of any constant stiffness exactly at the cap: E is the energy at which the cap
/// began to act. Where |s F| would exceed the cap (a lump, damping), E falls. Where it is below the cap, E rises again,
/// but only as far as the hand has put in more than S. Hence the hand gets back at most what it has put
/// in since the cap acts, and what is stored at the start: S where the force exceeds the cap from there.
class Saturation {
 public:
  /// What is known at a tick.
  struct Input {
    double force = 0.0;           ///< length of F [N]
    double potential = 0.0;       ///< U; infinity: unknown [J]
    double work = 0.0;            ///< of the hand against the rendered wrench since the last tick [J]
    double work_of_motion = 0.0;  ///< of surfaces that move, with the force F since the last tick [J]
  };
  /// The factor s; 1 where the potential is unknown: the caller then cuts the force to its length.
  double step(const Input& in, double cap) noexcept;
  /// The hand lets go: the energy is released.
  void reset() noexcept { *this = {}; }

 private:
  bool acts_ = false;     ///< the cap acts, or has acted and not all of it is undone
  double share_ = 1.0;    ///< s of the last tick
  double energy_ = 0.0;   ///< E [J]
  double left_ = 0.0;     ///< S of the last tick [J]
  double surplus_ = 0.0;  ///< what the hand has put in beyond S since the cap acts; negative: less [J]
};

}  // namespace palpate::stability
