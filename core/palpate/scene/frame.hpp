// Frames to which the geometry of a fixture is attached: fixed in the world, moving in closed form, or set live from
// outside.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "palpate/scene/motion.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::scene {

/// Pose and velocity of a frame F in the world W.
struct FrameState {
  Pose X_WF;
  Twist V_WF;  ///< velocity of F's origin and angular velocity of F, in W [m/s, rad/s]
};

/// A frame whose pose is known at any time.
class Frame {
 public:
  virtual ~Frame() = default;
  /// The frame at time t [s]. Allocation free.
  [[nodiscard]] virtual FrameState at(double t) const noexcept = 0;
};

/// A frame that moves in closed form, like an object of the scene. The default motion is none.
class MotionFrame final : public Frame {
 public:
  /// X_WF: pose at rest, which `motion` displaces.
  explicit MotionFrame(const Pose& X_WF, Motion motion = {});
  [[nodiscard]] FrameState at(double t) const noexcept override;

 private:
  Pose X_WF_;
  Motion motion_;
};

/// A frame whose pose is set live: a tool, a tracked camera, a handle in a viewer. One thread at a time may call set(),
/// any number of threads at(); neither blocks. Before the first set() the frame lies at the world's origin, and
/// fixtures attached to it have no authority (guidance/authority.cpp).
class LiveFrame final : public Frame {
 public:
  /// Sets the pose with its velocity, or without. see() estimates a missing velocity from successive poses and the
  /// ticks that saw them. If the estimate exceeds kMaxSpeed or kMaxTurnRate, or the poses are too rare, the frame has
  /// jumped and the estimate is zero.
  void set(const FrameState& state) noexcept { put(state, true); }
  void set(const Pose& X_WF) noexcept { put({X_WF, {}}, false); }
  [[nodiscard]] FrameState at(double) const noexcept override;

  /// Takes in the newest pose; the cycle's thread calls it at every tick, at time t [s].
  void see(double t) noexcept;
  /// True once a pose has been set.
  [[nodiscard]] bool has_pose() const noexcept { return updates_.load(std::memory_order_relaxed) > 0; }
  /// True in a tick whose see() found a jump: a new pose that no plausible motion explains.
  [[nodiscard]] bool jumped() const noexcept { return t_jump_ == t_; }
  /// Age of the newest pose at the last see() [s].
  [[nodiscard]] double age() const noexcept { return t_ - t_update_; }

  static constexpr double kMaxSpeed = 0.25,
                          kMaxTurnRate = 3.0;  ///< largest plausible speed [m/s] and angular speed [rad/s]

 private:
  static constexpr std::size_t kSlots = 8;           // a read is valid while fewer than kSlots - 1 newer poses are set
  using Slot = std::array<std::atomic<double>, 19>;  // R, p, v, w, and 1 if the velocity was given

  void put(const FrameState& state, bool with_velocity) noexcept;
  bool get(FrameState& state) const noexcept;

  std::array<Slot, kSlots> slots_{};
  std::atomic<std::size_t> updates_{0};  // number of poses set

  // State of see(): number of poses and newest pose seen, times, interval between the last two poses, estimated
  // velocity.
  std::size_t seen_ = 0;
  Pose X_seen_;
  double t_ = 0.0, t_update_ = 0.0, t_jump_ = -1.0, interval_ = 0.0;
  std::array<std::atomic<double>, 6> V_{};
};

using LiveFrames = std::vector<std::shared_ptr<LiveFrame>>;

}  // namespace palpate::scene
