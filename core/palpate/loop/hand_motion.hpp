// The simulated operator's intention: a path of the tool, turned into a motion of the hand.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/mapping/mapping.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// Way points of the tool in W, joined by quintics: the minimum-jerk motion (Flash and Hogan 1985) where both ends
/// rest. A way point is passed at the harmonic mean of the mean velocities a before and b after it,
///
///   v = 2 (a . b) / |a + b|^2 (a + b),   and v = 0 unless a . b > 0:
///
/// the hand rests at both ends, where a way point is repeated, and where the path turns by a right angle or more. Since
/// 0 <= v . a <= 2 |a|^2 (b likewise), it never goes back on the way from one to the next. Before the first and after
/// the last it rests. Empty: it stays where it starts.
class HandPath {
 public:
  struct Point {
    Vec3 p = Vec3::Zero();  ///< [m]
    Vec3 v = Vec3::Zero();  ///< [m/s]
    double gripper = 0.0;   ///< pinch [rad]
  };

  HandPath() = default;
  /// times: rising [s]; positions_W [m]; grippers: pinch at each way point [rad], or empty for an open hand.
  /// Throws std::invalid_argument naming the first way point that is wrong.
  HandPath(std::vector<double> times, std::vector<Vec3> positions_W, std::vector<double> grippers = {});

  [[nodiscard]] bool empty() const noexcept { return times_.empty(); }
  [[nodiscard]] Point at(double t) const noexcept;

 private:
  std::vector<double> times_;
  std::vector<Vec3> positions_, velocities_;
  std::vector<double> grippers_;
};

/// Where the hand wants the handle. The hand's place is the mapping's inverse of the tool's path, so that a hand
/// without contact would put the tool there. When the map is caught anew (clutch), the path is joined or the handle in
/// the viewer is dragged, the hand does not jump: it glides over, critically damped, at 0.25 m/s or slower.
class HandMotion {
 public:
  struct Target {
    Pose X_LH;
    Twist V_LH;            ///< in L
    double gripper = 0.0;  ///< [rad]
  };

  /// tremor: rms of an 8-12 Hz trembling along each axis [m]; seed: its phases.
  HandMotion(HandPath path, const Pose& X_WL, double tremor, std::uint64_t seed);

  /// The hand rests at X_LH and keeps this orientation.
  void start(const Pose& X_LH) noexcept;
  /// Once per tick: the map as it is now, how far the viewer drags the hand [m], and whether its path waits.
  void follow(const mapping::Mapping& mapping, const Vec3& p_offset_W, bool hold, double t) noexcept;
  /// In the coming tick the hand goes straight, at one speed, to where it is p_W beside all this [m]: what an operator
  /// does who sees and feels, and so cannot be told beforehand. It does not glide: the operator's own motion is the
  /// law.
  void lead(const Vec3& p_W, double tick) noexcept { v_lead_ = (p_W - lead_) / tick; }
  /// It stays where it was led to.
  void stay() noexcept { v_lead_.setZero(); }
  /// dt later.
  const Target& step(double dt) noexcept;

 private:
  struct Sway {
    Vec3 amplitude = Vec3::Zero(), phase = Vec3::Zero();
    double omega = 0.0;
  };
  [[nodiscard]] HandPath::Point wanted(double t) const noexcept;

  HandPath path_;
  Pose X_WL_;
  std::vector<Sway> tremor_;
  // p_WH = origin + offset + gain * path: the inverse map as it is now.
  Vec3 origin_ = Vec3::Zero(), offset_ = Vec3::Zero();
  double gain_ = 0.0;
  Vec3 glide_ = Vec3::Zero(), v_glide_ = Vec3::Zero();  ///< still to go [m], [m/s]
  Vec3 lead_ = Vec3::Zero(), v_lead_ = Vec3::Zero();    ///< [m], [m/s]
  double t_ = 0.0;
  bool hold_ = false;
  double t_hold_ = 0.0, held_ = 0.0;  ///< where the path waits, and how long it has waited so far [s]
  Target target_;
};

}  // namespace palpate::loop
