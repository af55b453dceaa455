// Camera teleoperation (mtsTeleOperationECM): while the camera pedal is pressed, both MTMs move the endoscope. A spring
// keeps the distance between the hands; their midpoint turns and inserts the endoscope. Note for haptic clients: it
// sets body/set_cf_orientation_absolute to true on both MTMs and never resets it.
#pragma once

#include "dvrk/arm.hpp"

namespace palpate::dvrk {

/// Teleoperation of an ECM by two MTMs.
class CameraTeleop {
 public:
  CameraTeleop(SimulatedArm& mtml, SimulatedArm& mtmr, SimulatedArm& ecm) : mtml_(&mtml), mtmr_(&mtmr), ecm_(&ecm) {}

  void enable(bool enable) noexcept;  ///< starts once all three arms are ready, or stops
  void run() noexcept;                ///< one period of 1 kHz
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
  void begin() noexcept;
  void push(SimulatedArm& mtm, const Vec3& p_goal) const noexcept;

  SimulatedArm *mtml_, *mtmr_, *ecm_;
  bool wanted_ = false, following_ = false;
  Image first_;
  JointVector q_first_;
  Mat3 R_left_ = Mat3::Identity(), R_right_ = Mat3::Identity();
};

}  // namespace palpate::dvrk
