// Stage `mapping`: maps the motion of the hand to the tool, and the force on the tool to the hand.
#pragma once

#include <limits>

#include "palpate/mapping/recentring.hpp"
#include "palpate/types/damped_wrench.hpp"
#include "palpate/types/motion.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::mapping {

/// Options of the stage.
struct Options {
  double scale = 0.5;        ///< tool motion per hand motion [-]; the felt stiffness is force_scale * scale * K
  double force_scale = 1.0;  ///< force on the hand per force on the tool [-]
  /// Rate at which the tool turns to the orientation of the handle after engaging, while nothing touches or pulls it
  /// [rad/s]; 0 keeps the offset.
  double align_rate = 0.5;
  double gripper_min = 0.0;      ///< pinch angle that closes the jaw [rad]
  double gripper_max = 1.047;    ///< pinch angle that opens the jaw fully [rad]
  double jaw_min = 0.0;          ///< jaw angle when closed [rad]
  double jaw_max = 1.047;        ///< jaw angle when fully open [rad]
  double jaw_start = 0.0;        ///< jaw angle of a simulated follower at the start [rad]
  double jaw_rate = 2.0;         ///< largest speed of the jaw [rad/s]
  bool ratchet = false;          ///< on engaging, the jaw does not open before the pinch has closed to its angle
  double align_tolerance = 0.0;  ///< orientation error up to which the handle counts as aligned; 0: any [rad]
  RecentringOptions recentring;  ///< motion of the tool in addition to that of the hand, for small workspaces
};

/// Input of the stage at every tick.
struct Input {
  Pose X_WH;              ///< measured pose of the handle in W
  Twist V_LH;             ///< velocity of the handle in L
  double gripper = 0.0;   ///< pinch angle, 0 = closed [rad]
  Pose X_WT;              ///< measured pose of the tool in W
  double jaw = 0.0;       ///< measured jaw angle [rad]
  bool following = true;  ///< teleoperation is on
  bool clutch = false;    ///< clutch pedal pressed
  bool reached = true;    ///< the follower reported its state and could reach the last goal (inverse kinematics)
  double t = std::numeric_limits<double>::quiet_NaN();   ///< time; NaN: one period after the last step [s]
  Vec3 p_LH = Vec3::Zero();                              ///< position of the handle in L [m]
  Vec3 F_T_W = Vec3::Zero();                             ///< newest force on the tool, of contacts and fixtures [N]
  Vec3 correction_W = Vec3::Zero();                      ///< displacement of the last goal by hard fixtures [m]
  bool lock_rotation = false, lock_translation = false;  ///< the tool keeps its orientation, its position
  bool pause_asked = false;                              ///< people ask for a pause, e.g. by the clutch pedal
  Vec3 t_T_W = Vec3::Zero();                             ///< newest moment on the tool, of contacts and fixtures [N m]
};

/// Relative, scaled position and absolute orientation (Fig 4):
///
///   p_WT = p_WT0 + scale (p_WH - p_WH0)        R_WT = R_WH R_off,   R_off -> 1 at align_rate
///
/// R_off changes only while no wrench acts on the tool: the tool would otherwise turn by itself into what it touches,
/// and the hand would receive energy that it did not put in.
///
/// The anchor (p_WT0, p_WH0, R_off) is set when the tool starts to follow: on engaging and on releasing the clutch. The
/// goal therefore continues from the held goal, without a jump. For small workspaces a `Recentring` moves p_WT0. While
/// the clutch is pressed or teleoperation is off, the tool holds the last goal, or its present pose if it did not reach
/// that goal.
///
/// A pause that nobody asked for shifts the tool against the hand by what the hand moved meanwhile. shift() adds up
/// such pauses; take_back() lets the tool return slowly while it touches nothing. A pause that people ask for chooses a
/// new relation of both: the shift is zero after it.
class Mapping {
 public:
  /// R_WL: orientation of the leader base L in W. dt: period of the cycle [s]. Throws std::invalid_argument with the
  /// name of an invalid option.
  Mapping(const Options& options, const Mat3& R_WL, double dt);

  /// Computes the goal of the tool for this tick.
  ToolGoal step(const Input& in) noexcept;
  /// Reports the goal that was finally commanded in this tick, after corrections by hard fixtures. A tool that does not
  /// follow holds this goal.
  void set_commanded_goal(const Pose& X_WT_goal) noexcept {
    if (!engaged_) goal_ = X_WT_goal;
  }
  /// Sets another motion scale (above 0), valid from the next step on. That step sets a new anchor, so the goal does
  /// not jump.
  void rescale(double scale) noexcept {
    options_.scale = scale;
    engaged_ = false;
    pause_asked_ = true;
  }
  /// Sets another orientation of the leader base L in W, valid from the next step on, without a jump of the goal.
  void turn(const Mat3& R_WL) noexcept {
    R_WL_ = R_WL;
    engaged_ = false;
    pause_asked_ = true;
  }
  /// Position of the tool minus where it would be without pauses that nobody asked for, in W [m].
  [[nodiscard]] const Vec3& shift() const noexcept { return shift_; }
  /// Lets the tool return by the shift, from the next step on.
  void take_back() noexcept { taking_back_ = true; }
  /// True if the handle at X_WH has the orientation of the tool at X_WT, within align_tolerance.
  [[nodiscard]] bool aligned(const Pose& X_WH, const Pose& X_WT) const noexcept;
  /// Force on the hand in L that renders a force on the tool in W: F_H_L = force_scale R_LW F_T_W [N].
  [[nodiscard]] Vec3 force_on_hand(const Vec3& F_T_W) const noexcept;
  /// Wrench on the hand about the origin of the handle, in L, that renders a wrench about the tool tip, in W. The hand
  /// turns by the same angle as the tool but moves 1/scale as far, so its moment is force_scale / scale times that of
  /// the tool. The power at the hand is then the power at the tool times energy_ratio(), and the mapping preserves
  /// passivity.
  [[nodiscard]] Wrench wrench_on_hand(const Wrench& F_T_W) const noexcept;
  /// Same as wrench_on_hand(), for a wrench with damping. The hand moves 1/scale as far as the tool, so it feels
  /// force_scale * scale times the damping.
  [[nodiscard]] DampedWrench damped_wrench_on_hand(const DampedWrench& on_tool) const noexcept;
  /// Stiffness that the hand feels for a stiffness K at the tool [N/m].
  [[nodiscard]] double stiffness_on_hand(double K) const noexcept { return options_.force_scale * options_.scale * K; }
  /// Torque on the operator's fingers that renders a torque on the jaws [N m]: the power at the fingers is the power at
  /// the jaws times energy_ratio(). Both are positive when they open.
  [[nodiscard]] double torque_on_fingers(double tau_jaw) const noexcept {
    return energy_ratio() * (options_.jaw_max - options_.jaw_min) / (options_.gripper_max - options_.gripper_min) *
           tau_jaw;
  }
  /// Ratio of the energy at the hand to the energy at the tool [-].
  [[nodiscard]] double energy_ratio() const noexcept { return options_.force_scale / options_.scale; }
  /// Position of the handle in W for which the tool goal is at p_WT [m]: the inverse of the position map with the
  /// present anchor.
  [[nodiscard]] Vec3 hand_position(const Vec3& p_WT) const noexcept;
  /// Energy that the springs at the tool lost in this step because p_WT0 moved, never below zero; the hand does not
  /// get it back [J].
  [[nodiscard]] double released() const noexcept { return recentring_.released(); }
  /// Number of times that the anchor was set.
  [[nodiscard]] int anchor_count() const noexcept { return anchor_count_; }
  /// The options, with the scale of the last rescale().
  [[nodiscard]] const Options& options() const noexcept { return options_; }

 private:
  void anchor(const Input& in) noexcept;
  void return_by_shift(double dt) noexcept;
  [[nodiscard]] double elapsed(double t) noexcept;

  Options options_;
  Mat3 R_WL_;
  double dt_;
  Recentring recentring_;
  double t_ = std::numeric_limits<double>::quiet_NaN();
  bool started_ = false, engaged_ = false;
  bool lock_rotation_ = false, lock_translation_ = false;
  bool jaw_held_ = false;     ///< ratchet: the pinch has not yet closed to the angle of the jaw
  bool pause_asked_ = false;  ///< people asked for the present pause
  bool taking_back_ = false;
  int anchor_count_ = 0;
  Vec3 shift_ = Vec3::Zero();
  Vec3 p_WH0_ = Vec3::Zero(), p_WT0_ = Vec3::Zero();
  Eigen::Quaterniond R_off_ = Eigen::Quaterniond::Identity();
  Pose goal_;
  double jaw_ = 0.0;
};

}  // namespace palpate::mapping
