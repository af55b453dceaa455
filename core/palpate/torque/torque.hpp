// Stage `torque`: joint torques that render a wrench by one of the control laws and balance the arm's weight.
#pragma once

#include <memory>
#include <string>

#include "palpate/arm/arm.hpp"
#include "palpate/torque/law.hpp"
#include "palpate/torque/terms.hpp"
#include "palpate/types/arms.hpp"
#include "palpate/types/damped_wrench.hpp"

namespace palpate::torque {

/// Joints that render the wrench.
enum class Mode { full, paper };  ///< full: all joints; paper: first three, wrist torques exactly zero (section 2.3)

/// Options of the stage.
struct Options {
  std::string law = "stiffness";  ///< name of the control law (law.cpp)
  Mode mode = Mode::full;         ///< joints that render the wrench
  double force_gain = 1.0;        ///< factor on tau_force, 0..1 [-]
  double gravity_gain = 1.0;      ///< factor on the gravity compensation [-]
  double platform_gain = 0.5;     ///< factor on the dVRK's joint-4 controller, 0..1 [-]; 7-joint MTMs in full mode only
  FrictionOptions friction;       ///< friction compensation
  LimitOptions limits;            ///< soft stops at the joint limits
  ControlLawOptions laws;         ///< options of the control laws
  double law_cap = 10.0;          ///< largest force that a law may add to the rendered force [N]
  double fast_force = 0.3;        ///< threshold of the neglected inertia force for the status bit too_fast [N]
  JointVector rotor_inertia;      ///< rotor inertia of the controller's model at the joints (n,) [kg m^2]; empty: none
};

/// Fraction of the arm's friction that friction compensation or the control law removes, 0-1. dt: period of the cycle
/// [s]. Throws std::invalid_argument with the name of an invalid option of the law.
[[nodiscard]] double removed_friction(const Options& options, double dt);

/// Input of the stage at every tick.
struct Input {
  const LeaderState& leader;  ///< measured state of the leader
  DampedWrench on_hand;       ///< wrench to render on the hand, in L; its damping is zero unless renders_damping()
  bool fresh = true;          ///< false if the leader state is stale: the wrench of the law fades, and the law is reset
};

/// Joint torques tau = tau_force + tau_gravity + tau_limits + tau_platform + tau_friction. In mode `full`,
///
///   tau_force = J^T (F + wrench of the law)
///
/// In mode `paper`, tau_force uses the first three joints and no moments, and all torques of the wrist joints are
/// exactly zero (the hand holds the wrist).
///
/// The drive limits are allotted to the terms in this order: gravity, limits, platform, friction, force, moments. If
/// the force does not fit, it is scaled down as a whole, so that its direction stays the same.
class Torque {
 public:
  /// tau_max: drive limits (n,) [N m]. dt: period of the cycle [s]. Throws std::invalid_argument with the name of the
  /// option, its value and the remedy.
  Torque(Options options, JointVector tau_max, double dt);

  /// Computes the torque terms `out` for this tick. model: arm model of the controller, after dynamics() at the
  /// leader's state. out.F_H_L is the part of on_hand.F that the drives can render. Returns bits of Status.
  unsigned step(arm::Arm& model, const Input& in, LeaderCommand& out) noexcept;
  /// True if the law itself renders the damping of Input::on_hand.
  [[nodiscard]] bool renders_damping(const LeaderState& leader) const noexcept;

 private:
  unsigned step_law(arm::Arm& model, const Input& in, LeaderCommand& out) noexcept;
  bool saturate(const Input& in, const Jacobian& J, LeaderCommand& out) noexcept;

  Options options_;
  JointVector tau_max_;
  double dt_;
  std::unique_ptr<ControlLaw> law_;
  Vec3 v_filtered_ = Vec3::Zero();  ///< low-pass filtered velocity of the handle in L [m/s]
  bool started_ = false;
};

}  // namespace palpate::torque
