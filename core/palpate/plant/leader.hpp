// A simulated leader: rigid-body dynamics, friction, drives, encoders, held by a simulated hand.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "palpate/arm/arm.hpp"
#include "palpate/plant/hand.hpp"
#include "palpate/types/arms.hpp"

namespace palpate::plant {

/// What a leader arm is made of besides its rigid bodies (facts of the hardware, per arm in models/*.yaml).
struct LeaderOptions {
  JointMatrix coupling;          ///< A: q_joint = A q_motor
  JointVector encoder_step;      ///< motor-side resolution [rad/count]; 0 = ideal
  JointVector coulomb;           ///< Fc [N m]
  JointVector viscous;           ///< Fv [N m s/rad]
  JointVector rotor_inertia;     ///< reflected to the joint [kg m^2]
  JointVector tau_max;           ///< drive limits, joint side [N m]
  double loop_delay = 0.0;       ///< from command to torque, force term only [s]
  double loop_jitter = 0.0;      ///< on top of it: uniform from 0 to this, of each command anew, order kept [s]
  double drive_lag = 0.0;        ///< time constant of the drives' current loops, of all torque [s]
  double hold_timeout = 0.03;    ///< drive without a fresh command: force term ramps to zero [s]
  double velocity_window = 0.0;  ///< 0: time between edges; else the difference of two positions so far apart [s]
  double velocity_cutoff = 0.0;  ///< of a first-order low-pass of the velocities; 0 = none [Hz]
  double cell_noise = 0.0;       ///< of the load cell in the handle, rms per axis [N]
  std::uint64_t seed = 0;        ///< of that noise, and of the jitter
  bool quantised = true;         ///< encoders as above, or the truth
};

/// One plant step is one servo period (10 kHz). Everything noexcept is allocation free.
class Leader {
 public:
  /// Throws std::invalid_argument naming the option, its value and the remedy.
  Leader(arm::Arm plant_model, LeaderOptions options, HandOptions hand);
  Leader(Leader&&) noexcept;
  Leader& operator=(Leader&&) noexcept;
  ~Leader();

  /// Places the arm at rest; the hand holds the handle where it is.
  void reset(const JointVector& q) noexcept;
  /// The newest command; the drive holds it until the next one.
  void command(const LeaderCommand& command) noexcept;
  /// The hand pinches the grips (0 = closed) [rad].
  void pinch(double gripper) noexcept;
  /// Another hand takes the handle, or none (HandOptions of zeros). Its values must be as the constructor's.
  void grip(const HandOptions& hand) noexcept;
  /// One servo period. X_LH_hand: where the hand wants the handle; v: velocity of that path (base frame L). F_push_L:
  /// on the handle besides, whoever holds it.
  void step(double dt, const Pose& X_LH_hand, const Twist& V_LH_hand, const Wrench& F_push_L = {}) noexcept;

  [[nodiscard]] const LeaderState& measured() const noexcept;  ///< encoders
  [[nodiscard]] const JointVector& q() const noexcept;         ///< truth, for judges only
  [[nodiscard]] const JointVector& v() const noexcept;         ///< truth
  [[nodiscard]] const Wrench& load_cell() const noexcept;      ///< of the arm on the hand, in L
  [[nodiscard]] bool hand_slipped() const noexcept;            ///< grip force limit reached in this step
  [[nodiscard]] double energy() const noexcept;  ///< kinetic + potential, of arm, spring and hand mass [J]

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::plant
