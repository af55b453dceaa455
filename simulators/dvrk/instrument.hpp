// The instrument of a PSM: sterile adapter, tool, and the tool's jaw.
#pragma once

#include "dvrk/outbox.hpp"
#include "dvrk/spec.hpp"
#include "dvrk/trajectory.hpp"

namespace palpate::dvrk {

/// Sterile adapter, tool and jaw of a PSM.
class Instrument {
 public:
  explicit Instrument(const ArmSpec& spec);

  // Presence of adapter and tool.
  void set_adapter_present(bool present, const EventPublisher& publisher) noexcept;
  void set_tool_present(bool present, const EventPublisher& publisher) noexcept;
  void set_tool_type(const Text& type, const EventPublisher& publisher) noexcept;
  [[nodiscard]] bool tool_present() const noexcept { return adapter_ && tool_; }
  [[nodiscard]] bool engaged() const noexcept { return engaged_; }
  /// True if a tool of known type is present but not yet engaged.
  [[nodiscard]] bool can_engage() const noexcept { return !engaged_ && tool_present() && !type_.empty(); }
  /// True if the tool or adapter was mounted since the last engagement, so that its disks have to be turned to engage.
  [[nodiscard]] bool newly_mounted() const noexcept { return newly_mounted_; }
  /// Engages a tool that can_engage().
  void engage(const EventPublisher& publisher) noexcept;
  void release() noexcept { engaged_ = false; }

  // The jaw: positions [rad], torque [N m]. A torque closes or opens the jaw to its stop.
  void servo_jp(double q) noexcept;
  void move_jp(double q, double ratio_v, double ratio_a) noexcept;
  void servo_jf(double tau) noexcept;
  [[nodiscard]] bool moving() const noexcept { return path_.active(); }
  /// One servo period. Returns true if a move has just reached its goal.
  bool run(double dt, bool powered) noexcept;
  void hold() noexcept;

  // Limits of the jaw's angle [rad].
  [[nodiscard]] double q_min() const noexcept { return q_min_; }
  [[nodiscard]] double q_max() const noexcept { return q_max_; }
  [[nodiscard]] const JointState& measured() const noexcept { return measured_; }
  [[nodiscard]] const JointState& setpoint() const noexcept { return setpoint_; }

 private:
  double q_min_, q_max_, v_max_, a_max_, tau_max_;
  bool adapter_ = true, tool_ = false, engaged_ = false, newly_mounted_ = false, by_torque_ = false;
  Text type_;
  Trajectory path_;
  JointState measured_, setpoint_;  // one joint
};

}  // namespace palpate::dvrk
