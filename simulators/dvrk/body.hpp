// The body of an arm with its joint servos: it takes the controller's orders and reports encoders and motor currents.
#pragma once

#include <array>
#include <memory>

#include "dvrk/spec.hpp"

namespace palpate::dvrk {

/// The controller's order to the joint servos; it stays in force until the next order.
struct Order {
  bool on = false;                           ///< drives powered and servos on
  std::array<bool, kMaxJoints> by_torque{};  ///< control of each joint: true by torque, false by position
  JointVector q, v;                          ///< goals of joints in position control [rad, m], [rad/s, m/s]
  JointVector tau;                           ///< torque, or the feed-forward of position control [N m, N]
};

/// Mechanical surroundings of the arm, in its own base frame.
struct Surroundings {
  bool held = false;  ///< a hand holds the handle
  Pose X_hand;        ///< pose of the handle that the hand intends
  Wrench F;           ///< additional wrench on the tip, of a person or of tissue [N, N m]
};

/// A simulated arm with its joint servos.
class Body {
 public:
  Body() = default;
  virtual ~Body() = default;
  Body(const Body&) = delete;
  Body& operator=(const Body&) = delete;

  /// Moves the joints to q, at rest, with the servos off.
  virtual void reset(const JointVector& q) noexcept = 0;
  /// Sets the order; called once per servo period.
  virtual void command(const Order& order) noexcept = 0;
  /// Advances by dt [s].
  virtual void step(double dt, const Surroundings& around) noexcept = 0;
  [[nodiscard]] virtual const JointState& measured() const noexcept = 0;  ///< by encoders and motor currents
  [[nodiscard]] virtual JointState truth() const noexcept = 0;            ///< true positions and velocities
  [[nodiscard]] virtual const Wrench& F_hand() const noexcept = 0;        ///< wrench of the arm on the hand
};

/// A body moved by torques (plant::Leader) if spec.dynamic, else one with ideal joint servos (plant::Follower). Throws
/// std::invalid_argument.
[[nodiscard]] std::unique_ptr<Body> make_body(const ArmSpec& spec);

}  // namespace palpate::dvrk
