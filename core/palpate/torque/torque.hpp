// Stage `torque`: joint torques that render a wrench by one of the control laws, and hold the arm's own weight.
#pragma once

#include <memory>
#include <string>

#include "palpate/arm/arm.hpp"
#include "palpate/torque/law.hpp"
#include "palpate/torque/terms.hpp"
#include "palpate/types/arms.hpp"
#include "palpate/types/damped_wrench.hpp"

namespace palpate::torque {

enum class Mode { full, paper };  ///< paper: first three joints only, wrist torques exactly zero (section 2.3)

struct Options {
  std::string law = "stiffness";  ///< of law.cpp
  Mode mode = Mode::full;
  double force_gain = 1.0;     ///< 0 switches tau_force off
  double gravity_gain = 1.0;   ///< 0 switches gravity compensation off
  double platform_gain = 0.5;  ///< joint-4 controller of the dVRK, 0..1: 7-joint MTMs in full mode; it needs a gimbal
  FrictionOptions friction;
  LimitOptions limits;
  LawOptions laws;
  double law_cap = 10.0;      ///< most that a law may add to the rendered force [N]
  double fast_force = 0.3;    ///< more inertia than this beside the rendered force is told: too_fast [N]
  JointVector rotor_inertia;  ///< of the controller's model, reflected [kg m^2]; empty: none
};

/// Input of the stage at every tick.
struct Input {
  const LeaderState& leader;
  DampedWrench on_hand;  ///< to render on the hand, in L; its damping is zero unless takes_damping()
  bool fresh = true;     ///< the leader's state is new; otherwise the law's own wrench fades, and the law is reset
};

/// tau = tau_force + tau_gravity + tau_limits + tau_platform + tau_friction, with
///   full:  tau_force = J^T (F + what the law adds);      paper: the same with the first three joints and no moments,
///   and every term of the wrist joints is exactly zero (the hand holds the wrist).
/// The drives' limits are given out in this order: gravity, limits, platform, friction, force, moments; what does not
/// fit of the force is taken off as a whole, its direction kept.
class Torque {
 public:
  /// tau_max (n,) [N m]; dt: period of the cycle [s]. Throws std::invalid_argument naming the option, its value and
  /// the mend.
  Torque(Options options, JointVector tau_max, double dt);

  /// `model` is the controller's arm, after dynamics() at the leader's state. Answers the bits of Status; out.F_H_L is
  /// the part of on_hand.F that the drives render.
  unsigned step(arm::Arm& model, const Input& in, LeaderCommand& out) noexcept;
  /// True when the law renders the damping of Input::on_hand by itself.
  [[nodiscard]] bool takes_damping(const LeaderState& leader) const noexcept;

 private:
  unsigned law(arm::Arm& model, const Input& in, LeaderCommand& out) noexcept;
  bool fit(const Input& in, const Jacobian& J, LeaderCommand& out) noexcept;

  Options options_;
  JointVector tau_max_;
  double dt_;
  std::unique_ptr<Law> law_;
  Vec3 v_slow_ = Vec3::Zero();  ///< the handle's velocity, low-passed [m/s]
  bool started_ = false;
};

}  // namespace palpate::torque
