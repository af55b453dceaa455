// Both MTMs move the camera (mtsTeleOperationECM), while the camera pedal is pressed: a spring keeps the hands at their
// distance, their middle turns and pushes the endoscope. What a haptic client has to know of it: it sets
// body/set_cf_orientation_absolute TRUE on both MTMs and never takes it back.
#pragma once

#include "dvrk/arm.hpp"

namespace palpate::dvrk {

class CameraTeleop {
 public:
  CameraTeleop(Arm& mtml, Arm& mtmr, Arm& ecm) : mtml_(&mtml), mtmr_(&mtmr), ecm_(&ecm) {}

  void enable(bool enable) noexcept;
  void run() noexcept;  ///< one period of 1 kHz
  [[nodiscard]] bool following() const noexcept { return following_; }

 private:
  /// The two hands as an image: its middle C, its up, half its width w across and its depth d along C.
  struct Image {
    Vec3 C = Vec3::Zero(), up = Vec3::Zero(), side = Vec3::Zero();
    double w = 0.0, d = 0.0;
    bool valid = false;  ///< the hands are apart, and the middle is not at the origin
  };
  [[nodiscard]] Image image() const noexcept;
  void begin() noexcept;
  void push(Arm& mtm, const Vec3& p_goal) const noexcept;

  Arm *mtml_, *mtmr_, *ecm_;
  bool wanted_ = false, following_ = false;
  Image first_;
  JointVector q_first_;
  Mat3 R_left_ = Mat3::Identity(), R_right_ = Mat3::Identity();
};

}  // namespace palpate::dvrk
