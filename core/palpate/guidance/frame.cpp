#include "palpate/guidance/frame.hpp"

#include <stdexcept>
#include <utility>

namespace palpate::guidance {

MotionFrame::MotionFrame(const Pose& X_WF, scene::Motion motion) : X_WF_(X_WF), motion_(std::move(motion)) {}

FrameState MotionFrame::at(double t) const noexcept {
  const Pose X_WF = motion_.pose(X_WF_, t);
  return {X_WF, {motion_.velocity(X_WF.p, t), motion_.spin(t)}};
}

Placed::Placed(GeometryPtr geometry, const Pose& X_FG, std::shared_ptr<const Frame> frame)
    : geometry_(std::move(geometry)), X_FG_(X_FG), frame_(std::move(frame)) {
  if (geometry_ == nullptr || frame_ == nullptr) throw std::invalid_argument("a geometry and a frame are needed");
}

Query Placed::answer(const Pose& X_WT, double t) const noexcept {
  const auto [X_WF, V_WF] = frame_->at(t);
  const Pose X_WG = X_WF * X_FG_;
  Query q = geometry_->query(X_WG.inverse() * X_WT, t);
  q.point = X_WG * q.point;
  q.normal = X_WG.R * q.normal;
  q.basis = X_WG.R * q.basis;
  q.attitude = X_WG.R * q.attitude;
  q.spin = V_WF.w + X_WG.R * q.spin;
  q.velocity = V_WF.v + V_WF.w.cross(q.point - X_WF.p) + X_WG.R * q.velocity;
  return q;
}

}  // namespace palpate::guidance
