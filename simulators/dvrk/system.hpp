// The simulated dVRK: arms, console, pedals and teleoperations, stepped together on one clock. A client talks to it in
// commands, states and events (messages.hpp); a bus adapter maps those to topics and adds nothing.
//
// One thread calls it. step(), apply(), next() and the states are noexcept and allocate nothing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dvrk/messages.hpp"
#include "dvrk/spec.hpp"

namespace palpate::dvrk {

class System {
 public:
  /// Plant at 3 kHz; arms every second tick, as the real ones (1.5 kHz); teleops every third (1 kHz).
  static constexpr double kTick = 1.0 / 3000.0;  ///< [s]

  /// Throws std::invalid_argument naming the arm, the option and the mend.
  explicit System(SystemSpec spec);
  System(System&&) noexcept;
  System& operator=(System&&) noexcept;
  ~System();

  [[nodiscard]] const std::vector<std::string>& arms() const noexcept;     ///< names, such as MTMR
  [[nodiscard]] const std::vector<std::string>& teleops() const noexcept;  ///< names, such as MTMR_PSM1
  [[nodiscard]] ArmKind kind(int arm) const noexcept;
  [[nodiscard]] const std::vector<std::string>& joint_names(int arm) const noexcept;

  /// One tick. Whoever wants a millisecond takes three.
  void step() noexcept;
  /// Since the simulation began [s].
  [[nodiscard]] double t() const noexcept;

  /// Takes effect in the component's next period. False: no such component or verb; refusals are events.
  bool apply(const Command& command) noexcept;
  /// The oldest event not yet taken. False: there is none.
  bool next(Event& event) noexcept;
  /// Events that were dropped because nobody took them (room is for 2048).
  [[nodiscard]] std::size_t dropped_events() const noexcept;

  [[nodiscard]] const ArmState& arm(int arm) const noexcept;
  [[nodiscard]] const TeleopState& teleop(int teleop) const noexcept;

  /// crtk_msgs/QueryForwardKinematics: base_frame * tip. False: q has not one number per joint, or is not finite.
  bool forward_kinematics(int arm, const JointVector& q, Pose& cp) noexcept;
  /// crtk_msgs/QueryInverseKinematics: q in: where to begin, out: joints. False: out of reach or a wrong length.
  bool inverse_kinematics(int arm, const Pose& cp, JointVector& q) noexcept;
  /// cisst_msgs/ConvertFloat64Array actuator_to_joint_position: joints, a PSM's with the jaw, of actuators [rad, m].
  /// Empty: a wrong length, or not finite.
  JointVector joint_position(int arm, const JointVector& actuators) noexcept;

  /// For judges: true joint positions and velocities, and the torques of the drives.
  [[nodiscard]] JointState truth(int arm) const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::dvrk
