// Camera teleoperation (mtsTeleOperationECM): while the camera pedal is pressed, both MTMs move the endoscope. A spring
// keeps the distance between the hands; their midpoint turns and inserts the endoscope. Note for haptic clients: it
// sets body/set_cf_orientation_absolute to true on both MTMs and never resets it.
#pragma once

#include "dvrk/arm.hpp"

namespace palpate::dvrk {

/// Teleoperation of an ECM by two MTMs.
class CameraTeleop {
 public:
  CameraTeleop(SimulatedArm& mtml, SimulatedArm& mtmr, SimulatedArm& ecm, Outbox& out);

  void start() noexcept;                        ///< publishes the first states
  bool apply(const Command& command) noexcept;  ///< applies a command; false if it has no such verb
  void enable(bool enable) noexcept;            ///< starts once all three arms are ready, or stops
  void clutch(int button) noexcept;             ///< 0 released, 1 pressed, 2 tapped: nothing follows while pressed
  void run(double t) noexcept;                  ///< one period of 1 kHz, which ends at t [s]
  /// Name on the bus, such as MTML_MTMR_ECM.
  [[nodiscard]] const Text& name() const noexcept { return publisher_.name(); }
  [[nodiscard]] bool following() const noexcept { return following_; }

 private:
  /// Configuration of the two hands, which carry the image between them: midpoint C, unit vectors up and side, and half
  /// the vector from left to right, w along side and d along C [m].
  struct Image {
    Vec3 C = Vec3::Zero(), up = Vec3::Zero(), side = Vec3::Zero();
    double w = 0.0, d = 0.0;
    bool valid = false;  ///< the hands are apart, and the midpoint is not at the origin
  };
  [[nodiscard]] Image image() const noexcept;
  enum class Phase : unsigned char { disabled, setting_arms_state, enabled };
  static std::string_view name_of(Phase phase) noexcept;
  void enter(Phase phase) noexcept;
  void set_following(bool following) noexcept;
  void set_scale(double scale) noexcept;
  void begin() noexcept;
  void push(SimulatedArm& mtm, const Vec3& p_goal) const noexcept;

  SimulatedArm *mtml_, *mtmr_, *ecm_;
  EventPublisher publisher_;
  Phase phase_ = Phase::disabled;
  bool wanted_ = false, following_ = false, clutched_ = false;
  double scale_ = 1.0;  ///< insertion of the endoscope per displacement of the hands [-]
  Image first_;
  JointVector q_first_;
  Mat3 R_left_ = Mat3::Identity(), R_right_ = Mat3::Identity();
};

}  // namespace palpate::dvrk
