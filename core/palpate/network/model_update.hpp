// Updates of a local model while the hand touches it: no kick, and no energy that was not there before.
#pragma once

#include "palpate/network/packet.hpp"

namespace palpate::network {

/// Options of the updates.
struct UpdateOptions {
  double tank = 2e-4;        ///< energy in the tank at the start [J]
  double capacity = 2e-3;    ///< most energy that the tank keeps [J]
  double force_rate = 20.0;  ///< largest change of the force by an update [N/s]
  double speed = 0.1;        ///< largest speed of a surface that is updated [m/s]
  double least_sure = 0.5;   ///< a stiffness with a larger relative standard deviation is not taken [-]
};

/// What the hand does to the model in this tick.
struct Held {
  double depth = 0.0;          ///< below the surface as the model has it now; negative outside [m]
  Vec3 normal = Vec3::Zero();  ///< outward normal at the nearest point
  double dissipated = 0.0;  ///< energy that damping and friction of the model have dissipated since the last tick [J]
};

/// The parameters of one object as they are rendered. They approach the estimate as far as
///
///   |F(new) - F(now)| <= force_rate dt,     U(new) - U(now) <= tank,     U = 1/2 K depth^2,  F = K depth
///
/// allow, at the present position of the hand. The tank gains what an update takes from the spring and what the model
/// dissipates; it pays for what an update adds. Without contact updates cost nothing. The hand therefore never gets
/// back more than it has put in, and the tank's first content.
class ModelUpdate {
 public:
  /// now: the parameters of the scene.
  ModelUpdate(const UpdateOptions& options, const ModelEstimate& now);
  /// One tick towards `goal`; returns the parameters to render.
  const ModelEstimate& step(const ModelEstimate& goal, const Held& held, double dt) noexcept;
  [[nodiscard]] const ModelEstimate& now() const noexcept { return now_; }
  /// Energy in the tank [J].
  [[nodiscard]] double tank() const noexcept { return tank_; }
  /// Energy that updates have added to the springs less what they have taken, since the start [J].
  [[nodiscard]] double paid() const noexcept { return paid_; }

 private:
  UpdateOptions options_;
  ModelEstimate now_;
  double tank_, paid_ = 0.0;
};

}  // namespace palpate::network
