// Where a geometry is attached: to the world, to something that moves by a closed form, to what somebody tells live.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>

#include "palpate/guidance/geometry.hpp"
#include "palpate/scene/motion.hpp"

namespace palpate::guidance {

/// Where a frame is and how it moves.
struct FrameState {
  Pose X_WF;
  Twist V_WF;  ///< of F's origin and of F, in W
};

class Frame {
 public:
  virtual ~Frame() = default;
  /// At time t [s]. Allocation free.
  [[nodiscard]] virtual FrameState at(double t) const noexcept = 0;
};

/// Moves as an object of the scene does: camera, leader base and still organs have no motion.
class MotionFrame final : public Frame {
 public:
  explicit MotionFrame(const Pose& X_WF, scene::Motion motion = {});
  [[nodiscard]] FrameState at(double t) const noexcept override;

 private:
  Pose X_WF_;
  scene::Motion motion_;
};

/// Is where it was last told to be: a tool, a tracked camera, a handle in a viewer. One thread at a time tells, any
/// number ask; nobody waits. Until it is told for the first time it is at the world's origin, and what is attached to
/// it counts for nothing (guidance.cpp).
class LiveFrame final : public Frame {
 public:
  /// With its velocity, or without: then it has the one that leads from pose to pose, in the time between the cycles
  /// that saw them. Had it to be faster than kFastest or kTurns, it has leapt and is at rest; told seldom, too.
  void set(const FrameState& state) noexcept { put(state, true); }
  void set(const Pose& X_WF) noexcept { put({X_WF, {}}, false); }
  [[nodiscard]] FrameState at(double) const noexcept override;

  /// One thread, the cycle's, sees it: at every tick, at times t [s].
  void see(double t) noexcept;
  [[nodiscard]] bool told() const noexcept { return told_.load(std::memory_order_relaxed) > 0; }
  /// It was told anew, and not where a motion could have brought it.
  [[nodiscard]] bool leapt() const noexcept { return t_leapt_ == t_; }
  /// Since it was told anew, as of the last time it was seen [s].
  [[nodiscard]] double age() const noexcept { return t_ - t_told_; }

  static constexpr double kFastest = 0.25, kTurns = 3.0;  ///< [m/s], [rad/s]

 private:
  static constexpr std::size_t kSlots = 8;  // who asks may be overtaken by so many, less one
  using Slot = std::array<std::atomic<double>, 19>;

  void put(const FrameState& state, bool with_velocity) noexcept;
  bool get(FrameState& state) const noexcept;

  std::array<Slot, kSlots> slots_{};
  std::atomic<std::size_t> told_{0};  // how often; 0: never

  // As the cycle has seen it.
  std::size_t seen_ = 0;
  Pose X_seen_;
  double t_ = 0.0, t_told_ = 0.0, t_leapt_ = -1.0, interval_ = 0.0;
  std::array<std::atomic<double>, 6> V_{};
};

/// A geometry at X_FG in a frame.
class Placed final : public Geometry {
 public:
  /// Throws std::invalid_argument when a pointer is null.
  Placed(GeometryPtr geometry, const Pose& X_FG, std::shared_ptr<const Frame> frame);
  [[nodiscard]] bool solid() const noexcept override { return geometry_->solid(); }
  [[nodiscard]] bool is_point() const noexcept override { return geometry_->is_point(); }
  /// Also of what has none by itself, once somebody has turned it, or tells live how it is turned.
  [[nodiscard]] bool has_axis() const noexcept override;
  void add_live(LiveFrames& frames) const override;
  [[nodiscard]] Around normals(const Pose& X_WT, double t) const noexcept override;

 protected:
  [[nodiscard]] Query answer(const Pose& X_WT, double t) const noexcept override;

 private:
  GeometryPtr geometry_;
  Pose X_FG_;
  std::shared_ptr<const Frame> frame_;
};

}  // namespace palpate::guidance
