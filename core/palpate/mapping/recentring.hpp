// Motion of the tool in addition to that of the hand, so that a device with a small workspace reaches everywhere.
#pragma once

#include <cstdint>
#include <optional>

#include "palpate/types/spatial.hpp"

namespace palpate::mapping {

/// How the tool moves in addition to the hand.
enum class Law : std::uint8_t {
  position,  ///< not at all: the hand moves the tool, and the clutch moves the hand alone
  rate,      ///< near the rim of the workspace the tool continues outwards by itself
  drift,     ///< while the hand moves, the tool drifts outwards, and a hand that follows a target returns to the centre
};

struct RecentringOptions {
  Law law = Law::position;
  Vec3 workspace = Vec3::Zero();              ///< lengths of the workspace along the axes of L [m]
  std::optional<Vec3> centre = std::nullopt;  ///< its centre in L; without it, the handle's first position [m]
  double rim = 0.7;         ///< rate: distance from the centre at which it begins, 1 at the edge of the workspace [-]
  double rim_speed = 0.05;  ///< rate: speed of the tool at the edge, which is also the largest [m/s]
  double drift = 0.2;       ///< drift: speed of the drift at the edge over the speed that the hand gives the tool [-]
};

/// Input of a step.
struct RecentringInput {
  Vec3 p_LH;          ///< position of the handle in L [m]
  double speed;       ///< speed of the tool by the hand's motion [m/s]
  const Mat3& R_WL;   ///< orientation of L in W
  Vec3 F_T_W;         ///< newest force on the tool [N]
  Vec3 correction_W;  ///< displacement of the tool goal by hard fixtures [m]
  bool reached;       ///< the follower could reach the last goal
};

/// Let u be the position from the centre in half-lengths of the workspace, so that |u| = 1 on its ellipsoid, and e its
/// direction in W. The velocity of the tool in addition to that of the hand is
///
///   rate:   v = rim_speed s^2 e,  s = (|u| - rim) / (1 - rim) within 0 and 1     its change is bounded, too
///   drift:  v = drift min(|u|, 1) |v_T| e                                        v_T: tool velocity by the hand
///
/// Rate control at the rim follows the bubble technique (Dominjon et al. 2005), drift the workspace drift control of
/// Conti and Khatib (2005). A velocity against the force on the tool would load its springs with energy that no hand
/// has put in. That part of v is therefore removed, so that F_T . v >= 0: this motion only releases energy. It is also
/// removed where hard fixtures hold the goal back, and v is zero while the follower does not reach its goal.
class Recentring {
 public:
  /// Throws std::invalid_argument with the name of an invalid option.
  explicit Recentring(const RecentringOptions& options);

  /// Displacement of the tool in W during dt, in addition to that of the hand [m].
  Vec3 step(const RecentringInput& in, double dt) noexcept;
  /// To be called while the tool does not follow: the motion starts again from rest.
  void pause() noexcept {
    v_ = Vec3::Zero();
    released_ = 0.0;
  }
  /// Work of the force on the tool along the last displacement, never below zero [J].
  [[nodiscard]] double released() const noexcept { return released_; }

 private:
  [[nodiscard]] Vec3 wanted(const RecentringInput& in, double dt) const noexcept;

  RecentringOptions options_;
  bool started_ = false;
  Vec3 p_LC_ = Vec3::Zero();  ///< centre of the workspace in L [m]
  Vec3 v_ = Vec3::Zero();     ///< velocity of the last step, in W [m/s]
  double released_ = 0.0;
};

}  // namespace palpate::mapping
