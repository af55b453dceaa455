#include "palpate/guidance/geometry/framed.hpp"

#include <Eigen/Geometry>
#include <stdexcept>
#include <utility>

namespace palpate::guidance {

FramedGeometry::FramedGeometry(GeometryPtr geometry, const Pose& X_FG, std::shared_ptr<const scene::Frame> frame)
    : geometry_(std::move(geometry)), X_FG_(X_FG), frame_(std::move(frame)) {
  if (geometry_ == nullptr || frame_ == nullptr) throw std::invalid_argument("a geometry and a frame are needed");
}

bool FramedGeometry::has_axis() const noexcept {
  if (geometry_->has_axis() || dynamic_cast<const scene::LiveFrame*>(frame_.get()) != nullptr) return true;
  return !(frame_->at(0.0).X_WF.R * X_FG_.R).isIdentity(1e-9);
}

void FramedGeometry::add_live(LiveFrames& frames) const {
  const auto live = std::dynamic_pointer_cast<const scene::LiveFrame>(frame_);
  if (live != nullptr) frames.push_back(std::const_pointer_cast<scene::LiveFrame>(live));
  geometry_->add_live(frames);
}

QueryDerivatives FramedGeometry::normals(const Pose& X_WT, double t) const noexcept {
  const Pose X_WG = frame_->at(t).X_WF * X_FG_;
  QueryDerivatives out = geometry_->normals(X_WG.inverse() * X_WT, t);
  out.normal = X_WG.R * out.normal;
  out.d_normal = X_WG.R * out.d_normal * X_WG.R.transpose();
  return out;
}

Query FramedGeometry::query_local(const Pose& X_WT, double t, double exact_within) const noexcept {
  const auto [X_WF, V_WF] = frame_->at(t);
  const Pose X_WG = X_WF * X_FG_;
  Query q = geometry_->query(X_WG.inverse() * X_WT, t, exact_within);
  q.point = X_WG * q.point;
  q.normal = X_WG.R * q.normal;
  q.basis = X_WG.R * q.basis;
  q.attitude = X_WG.R * q.attitude;
  q.spin = V_WF.w + X_WG.R * q.spin;
  q.velocity = V_WF.v + V_WF.w.cross(q.point - X_WF.p) + X_WG.R * q.velocity;
  return q;
}

}  // namespace palpate::guidance
