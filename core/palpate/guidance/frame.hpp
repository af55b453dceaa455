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
/// number ask; nobody waits. Until it is told for the first time it is at the world's origin.
class LiveFrame final : public Frame {
 public:
  void set(const FrameState& state) noexcept;
  [[nodiscard]] FrameState at(double) const noexcept override;

 private:
  static constexpr std::size_t kSlots = 8;  // who asks may be overtaken by so many, less one
  using Slot = std::array<std::atomic<double>, 18>;
  std::array<Slot, kSlots> slots_{};
  std::atomic<std::size_t> told_{0};  // how often; 0: never
};

/// A geometry at X_FG in a frame.
class Placed final : public Geometry {
 public:
  /// Throws std::invalid_argument when a pointer is null.
  Placed(GeometryPtr geometry, const Pose& X_FG, std::shared_ptr<const Frame> frame);
  [[nodiscard]] bool solid() const noexcept override { return geometry_->solid(); }

 protected:
  [[nodiscard]] Query answer(const Pose& X_WT, double t) const noexcept override;

 private:
  GeometryPtr geometry_;
  Pose X_FG_;
  std::shared_ptr<const Frame> frame_;
};

}  // namespace palpate::guidance
