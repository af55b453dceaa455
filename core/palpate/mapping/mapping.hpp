// Stage `mapping`: what the tool should do when the hand does this, and how a force on the tool feels in the hand.
#pragma once

#include "palpate/types/damped_wrench.hpp"
#include "palpate/types/motion.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::mapping {

struct Options {
  double scale = 0.5;          ///< tool motion per hand motion [-]; felt stiffness = force_scale * scale * K
  double force_scale = 1.0;    ///< force on the hand per force on the tool [-]
  double align_rate = 0.5;     ///< how fast an orientation offset of engaging decays [rad/s]; 0 keeps it
  double gripper_min = 0.0;    ///< pinch of a closed jaw [rad]
  double gripper_max = 1.047;  ///< pinch of an open jaw [rad]
  double jaw_min = 0.0;        ///< closed [rad]
  double jaw_max = 1.047;      ///< open [rad]
  double jaw_rate = 2.0;       ///< the jaw catches up with the pinch no faster [rad/s]
};

/// Input of the stage at every tick.
struct Input {
  Pose X_WH;             ///< handle, measured
  Twist V_LH;            ///< handle velocity in L
  double gripper = 0.0;  ///< pinch [rad]
  Pose X_WT;             ///< tool, measured
  double jaw = 0.0;      ///< measured [rad]
  bool following = true;
  bool clutch = false;
  bool reached = true;  ///< the follower was heard and could take the last goal (inverse kinematics)
};

/// Relative scaled position, absolute orientation (Fig 4):
///
///   p_WT = p_WT0 + scale (p_WH - p_WH0)        R_WT = R_WH R_off,   R_off -> 1 at align_rate
///
/// (p_WT0, p_WH0, R_off) are caught whenever the tool starts to follow: on engaging and on releasing the clutch. So
/// the goal starts where the tool is, and nothing jumps. While the clutch is pressed or teleoperation is off
/// the tool holds: at the last goal, or where it is when it did not get there.
class Mapping {
 public:
  /// dt: period of the cycle [s]. Throws std::invalid_argument naming an option that cannot be.
  Mapping(const Options& options, const Mat3& R_WL, double dt);

  ToolGoal step(const Input& in) noexcept;
  /// The goal that was truly given in this tick. While the tool holds, it holds there.
  void given(const Pose& X_WT_goal) noexcept {
    if (!engaged_) goal_ = X_WT_goal;
  }
  /// Another scale (above 0), from the next step on: the map is caught anew.
  void rescale(double scale) noexcept {
    options_.scale = scale;
    engaged_ = false;
  }
  /// Force on the hand in L that renders a force on the tool in W: F_H_L = force_scale R_LW F_T_W. Free vectors
  /// only rotate.
  [[nodiscard]] Vec3 force_on_hand(const Vec3& F_T_W) const noexcept;
  /// The same of a wrench about the tool tip, about the handle's origin. The hand turns as far as the tool but moves
  /// 1/scale as far, so a moment is force_scale / scale times the tool's: then the hand's port is the tool's port times
  /// one factor, and what is passive there is passive here.
  [[nodiscard]] Wrench wrench_on_hand(const Wrench& F_T_W) const noexcept;
  /// The same of a wrench with damping; the hand moves 1/scale as far, so it feels force_scale * scale of the damping.
  [[nodiscard]] DampedWrench on_hand(const DampedWrench& on_tool) const noexcept;
  /// Stiffness that the hand feels of a stiffness at the tool [N/m].
  [[nodiscard]] double stiffness_on_hand(double K) const noexcept { return options_.force_scale * options_.scale * K; }
  /// Energy at the hand's port per energy at the tool's [-].
  [[nodiscard]] double energy_ratio() const noexcept { return options_.force_scale / options_.scale; }
  /// Where the handle has to be for the tool to be at p_WT: the inverse of the position map as caught last.
  [[nodiscard]] Vec3 hand_position(const Vec3& p_WT) const noexcept;
  /// How often the map was caught anew.
  [[nodiscard]] int anchorings() const noexcept { return anchorings_; }
  [[nodiscard]] const Options& options() const noexcept { return options_; }

 private:
  void anchor(const Input& in) noexcept;

  Options options_;
  Mat3 R_WL_;
  double dt_;
  bool started_ = false, engaged_ = false;
  int anchorings_ = 0;
  Vec3 p_WH0_ = Vec3::Zero(), p_WT0_ = Vec3::Zero();
  Eigen::Quaterniond R_off_ = Eigen::Quaterniond::Identity();
  Pose goal_;
  double jaw_ = 0.0;
};

}  // namespace palpate::mapping
