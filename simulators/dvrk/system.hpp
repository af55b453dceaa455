// The simulated dVRK: arms, console, pedals and teleoperations, stepped together on one clock. A client exchanges
// commands, states and events with it (messages.hpp); a bus adapter only maps these to topics.
//
// Only one thread may use it. step(), apply(), next() and the states are noexcept and allocate nothing.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dvrk/messages.hpp"
#include "dvrk/spec.hpp"

namespace palpate::dvrk {

/// A simulated dVRK.
class System {
 public:
  /// Period of a tick [s]. The plant runs at every tick (3 kHz), the arms at every second one, like the real ones
  /// (1.5 kHz), and the teleoperations at every third one (1 kHz).
  static constexpr double kTick = 1.0 / 3000.0;

  /// Throws std::invalid_argument naming the arm, the option and the remedy.
  explicit System(SystemSpec spec);
  System(System&&) noexcept;
  System& operator=(System&&) noexcept;
  ~System();

  [[nodiscard]] const std::vector<std::string>& arms() const noexcept;     ///< names, such as MTMR
  [[nodiscard]] const std::vector<std::string>& teleops() const noexcept;  ///< names, such as MTMR_PSM1
  /// Name of an existing component on the bus, such as MTMR or console.
  [[nodiscard]] std::string component_name(const Address& at) const;
  /// Addresses of all components of a kind; `arms`: kinds of arms that count, as ArmKind bits.
  [[nodiscard]] std::vector<Address> components(Kind kind, unsigned arms) const;
  [[nodiscard]] ArmKind kind(int arm) const noexcept;
  [[nodiscard]] const std::vector<std::string>& joint_names(int arm) const noexcept;

  /// One tick; three ticks are a millisecond.
  void step() noexcept;
  /// Time since the simulation began [s].
  [[nodiscard]] double t() const noexcept;

  /// Applies a command, which takes effect in the component's next period. Returns false if there is no such component
  /// or verb. A component reports a refusal as an event.
  bool apply(const Command& command) noexcept;
  /// Takes the oldest event. Returns false if there is no event.
  bool next(Event& event) noexcept;
  /// Number of events dropped because the queue of 2048 was full.
  [[nodiscard]] std::size_t dropped_events() const noexcept;

  [[nodiscard]] const ArmState& arm(int arm) const noexcept;
  [[nodiscard]] const TeleopState& teleop(int teleop) const noexcept;

  /// crtk_msgs/QueryForwardKinematics: cp = base_frame * tip. Returns false if q has a wrong length or is not finite.
  bool forward_kinematics(int arm, const JointVector& q, Pose& cp) noexcept;
  /// crtk_msgs/QueryInverseKinematics. q: initial guess in, joint positions out. Returns false if cp is out of reach,
  /// or if the input has a wrong length or is not finite.
  bool inverse_kinematics(int arm, const Pose& cp, JointVector& q) noexcept;
  /// cisst_msgs/ConvertFloat64Array actuator_to_joint_position: joint positions, for a PSM including the jaw, from
  /// actuator positions [rad, m]. Empty if the input has a wrong length or is not finite.
  JointVector joint_position(int arm, const JointVector& actuators) noexcept;

  /// For tests: true joint positions and velocities, and the torques of the drives.
  [[nodiscard]] JointState truth(int arm) const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate::dvrk
