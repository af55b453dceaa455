// The intended motion of the simulated operator: a path of the tool, converted into a motion of the hand.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "palpate/mapping/mapping.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// Way points of the tool in W, joined by quintic polynomials. Between two points of rest this is the minimum-jerk
/// motion (Flash and Hogan 1985). The velocity at a way point follows from the mean velocities a before and b after it:
///
///   v = 2 (a . b) / |a + b|^2 (a + b)   if a . b > 0,   else v = 0
///
/// The path therefore rests at both ends, where a way point is repeated, and where it turns by a right angle or more.
/// Since 0 <= v . a <= 2 |a|^2 (and likewise for b), it never moves backwards between two way points. It rests before
/// the first and after the last way point. An empty path stays at its start.
class HandPath {
 public:
  struct Point {
    Vec3 p = Vec3::Zero();  ///< position in W [m]
    Vec3 v = Vec3::Zero();  ///< velocity in W [m/s]
    double gripper = 0.0;   ///< pinch angle [rad]
  };

  /// Way points after the last query, where the next query looks first.
  struct Cursor {
    std::size_t point = 0, grip = 0;
  };

  HandPath() = default;
  /// times: increasing [s]; positions_W [m]; grippers: pinch angles [rad], or empty for an open hand; grip_times: their
  /// times [s], or empty for those of the positions. The angle moves between them by minimum jerk. Throws
  /// std::invalid_argument naming the first invalid way point.
  HandPath(std::vector<double> times, std::vector<Vec3> positions_W, std::vector<double> grippers = {},
           std::vector<double> grip_times = {});

  [[nodiscard]] bool empty() const noexcept { return times_.empty(); }
  /// The point of the path at the time t [s].
  [[nodiscard]] Point at(double t, Cursor& cursor) const noexcept;

 private:
  [[nodiscard]] Vec3 velocity(std::size_t i) const noexcept;
  [[nodiscard]] double pinch(double t, std::size_t& cursor) const noexcept;

  std::vector<double> times_;
  std::vector<Vec3> positions_;
  std::vector<double> grippers_, grip_times_;
};

/// The pose of the handle that the hand intends. The intended position is the inverse of the position map applied to
/// the path of the tool, so that without contact the tool follows its path. When the map is anchored anew (clutch), the
/// path begins or the viewer drags the hand, the hand does not jump. It moves to its new path, critically damped and
/// at 0.25 m/s or less.
class HandMotion {
 public:
  struct Target {
    Pose X_LH;             ///< intended pose of the handle
    Twist V_LH;            ///< its velocity, in L
    double gripper = 0.0;  ///< pinch angle [rad]
  };

  /// tremor: rms of an 8-12 Hz tremor along each axis [m]. seed: of the tremor's frequencies and phases.
  HandMotion(HandPath path, const Pose& X_WL, double tremor, std::uint64_t seed);

  /// Lets the hand rest at X_LH, whose orientation it keeps.
  void start(const Pose& X_LH) noexcept;
  /// To be called once per tick, at time t [s]. mapping: its present map; p_offset_W: offset from dragging in the
  /// viewer [m]; hold: the path is held.
  void follow(const mapping::Mapping& mapping, const Vec3& p_offset_W, bool paused, double t) noexcept;
  /// Sets another orientation of the leader base in W; the hand stays where it is in L.
  void turn(const Mat3& R_WL) noexcept;
  /// Moves the hand in the coming tick, of length `tick` [s], straight and at constant speed to the additional offset
  /// p_W [m]. An operator model that reacts to the run uses it. The offset is not smoothed.
  void steer(const Vec3& p_W, double tick) noexcept { v_steered_ = (p_W - steered_) / tick; }
  /// Keeps the offset that steer() has reached.
  void stop_steering() noexcept { v_steered_.setZero(); }
  /// Moves the pinch to an angle instead of the path's [rad]; NaN: as the path says.
  void grip(double pinch) noexcept { wanted_pinch_ = pinch; }
  /// Present pinch angle [rad].
  [[nodiscard]] double pinch() const noexcept { return target_.gripper; }
  /// Advances by dt [s] and returns the new target.
  const Target& step(double dt) noexcept;

 private:
  struct Sinusoid {
    Vec3 amplitude = Vec3::Zero(), phase = Vec3::Zero();
    double omega = 0.0;
  };
  [[nodiscard]] HandPath::Point intended(double t) noexcept;
  /// Moves the offset of a transition towards zero.
  void glide(double dt) noexcept;

  HandPath path_;
  HandPath::Cursor cursor_;
  Pose X_WL_, X_LW_;
  std::vector<Sinusoid> tremor_;
  // p_WH = origin + offset + gain * path: the present inverse map.
  Vec3 origin_ = Vec3::Zero(), offset_ = Vec3::Zero();
  double gain_ = 0.0;
  Vec3 glide_ = Vec3::Zero(), v_glide_ = Vec3::Zero();              ///< remaining offset of a transition [m], [m/s]
  Vec3 steered_ = Vec3::Zero(), v_steered_ = Vec3::Zero();          ///< offset of steer() [m], [m/s]
  double wanted_pinch_ = std::numeric_limits<double>::quiet_NaN();  ///< of grip()
  double t_ = 0.0;
  bool paused_ = false;
  double t_paused_ = 0.0, pause_duration_ = 0.0;  ///< time on the path where it is held; total time held [s]
  Target target_;
};

}  // namespace palpate::loop
