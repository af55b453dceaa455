// Where a geometry is attached: to the world, to something that moves by a closed form, to what somebody tells live.
#pragma once

#include "palpate/guidance/geometry.hpp"
#include "palpate/scene/motion.hpp"
#include "palpate/types/mailbox.hpp"

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

/// Is where it was last told to be: a tool, a tracked camera, a handle in a viewer. One thread tells, one asks; until
/// it is told for the first time it is at the world's origin.
class LiveFrame final : public Frame {
 public:
  void set(const FrameState& state) noexcept { mailbox_.write(state); }
  [[nodiscard]] FrameState at(double) const noexcept override { return mailbox_.read(); }

 private:
  mutable Mailbox<FrameState> mailbox_;  // reading it is what the cycle does, alone
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
