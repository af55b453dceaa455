// A simulated leader: rigid-body dynamics, friction, drives, encoders, held by a simulated hand.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "palpate/arm/arm.hpp"
#include "palpate/plant/hand.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::plant {

/// Parameters of a leader arm besides its rigid bodies (properties of the hardware, given per arm in models/*.yaml).
struct LeaderOptions {
  JointMatrix coupling;          ///< A: q_joint = A q_motor
  JointVector encoder_step;      ///< motor-side resolution [rad/count]; 0 = ideal
  JointVector coulomb;           ///< Fc [N m]
  JointVector viscous;           ///< Fv [N m s/rad]
  JointVector rotor_inertia;     ///< reflected to the joint [kg m^2]
  JointVector tau_max;           ///< drive limits, joint side [N m]
  double loop_delay = 0.0;       ///< delay from command to torque, of the force term only [s]
  double loop_jitter = 0.0;      ///< additional delay of each command, uniform in 0..loop_jitter; the order is kept [s]
  double drive_lag = 0.0;        ///< time constant of the drives' current loops, for the whole torque [s]
  double hold_timeout = 0.03;    ///< age of the last command after which the force term ramps to zero [s]
  double velocity_window = 0.0;  ///< 0: time between edges; otherwise difference of two positions this far apart [s]
  double velocity_cutoff = 0.0;  ///< cut-off of a first-order low-pass of the velocities; 0 = no filter [Hz]
  double cell_noise = 0.0;       ///< noise of the load cell in the handle, rms per axis [N]
  std::uint64_t seed = 0;        ///< seed of the noise and of the jitter
  bool quantised = true;         ///< measures by the encoders above; false: measures the true state
};

/// A simulated leader arm. One step is one servo period (10 kHz). Functions that are noexcept do not allocate.
class Leader {
 public:
  /// Throws std::invalid_argument naming the option, its value and the remedy.
  Leader(arm::Arm plant_model, LeaderOptions options, HandOptions hand);
  Leader(Leader&&) noexcept;
  Leader& operator=(Leader&&) noexcept;
  ~Leader();

  /// Places the arm at rest at q, within the joint limits.
  void reset(const JointVector& q) noexcept;
  /// Takes the newest command; the drives hold it until the next one.
  void command(const LeaderCommand& command) noexcept;
  /// Sets the pinch angle of the grips (0 = closed) [rad].
  void pinch(double gripper) noexcept;
  /// Replaces the hand; HandOptions of zeros mean no hand. The values must satisfy the constructor's conditions.
  void grip(const HandOptions& hand) noexcept;
  /// One servo period dt [s]. X_LH_hand, V_LH_hand: pose and velocity of the hand's intended path in the base frame L.
  /// F_push_L: additional wrench on the handle.
  void step(double dt, const Pose& X_LH_hand, const Twist& V_LH_hand, const Wrench& F_push_L = {}) noexcept;

  [[nodiscard]] const LeaderState& measured() const noexcept;  ///< encoders
  [[nodiscard]] const JointVector& q() const noexcept;         ///< true positions [rad]
  [[nodiscard]] const JointVector& v() const noexcept;         ///< true velocities [rad/s]
  [[nodiscard]] const Wrench& load_cell() const noexcept;      ///< wrench of the arm on the hand, in L
  [[nodiscard]] bool hand_slipped() const noexcept;  ///< true if the grip force limit was reached in the last step
  [[nodiscard]] double energy() const noexcept;      ///< kinetic and potential energy of arm, spring and hand [J]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::plant
