// The body of an arm with its joint servos: what the controller orders, and what its encoders and currents report.
#pragma once

#include <array>
#include <memory>

#include "dvrk/spec.hpp"

namespace palpate::dvrk {

/// What the controller orders from the joint servos; they keep to it until the next order.
struct Order {
  bool on = false;                           ///< drives powered and servos on
  std::array<bool, kMaxJoints> by_torque{};  ///< per joint: torque, or position
  JointVector q, v;                          ///< goals of the joints in position control
  JointVector tau;                           ///< torque; of joints in position control: fed forward [N m, N]
};

/// Who touches the arm, in its own base.
struct Surroundings {
  bool held = false;  ///< a hand is on the handle
  Pose X_hand;        ///< where it wants it
  Wrench F;           ///< on the tip besides (someone pushes, tissue)
};

class Body {
 public:
  Body() = default;
  virtual ~Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  virtual void reset(const JointVector& q) noexcept = 0;
  /// Once a servo period.
  virtual void command(const Order& order) noexcept = 0;
  virtual void step(double dt, const Surroundings& around) noexcept = 0;
  [[nodiscard]] virtual const JointState& measured() const noexcept = 0;  ///< encoders and motor currents
  [[nodiscard]] virtual JointState truth() const noexcept = 0;
  [[nodiscard]] virtual const Wrench& F_hand() const noexcept = 0;  ///< of the arm on the hand
};

/// By torques (plant::Leader), or servoed joints that no torque moves (plant::Follower). Throws std::invalid_argument.
[[nodiscard]] std::unique_ptr<Body> make_body(const ArmSpec& spec);

}  // namespace palpate::dvrk
