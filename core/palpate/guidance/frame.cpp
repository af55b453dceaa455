#include "palpate/guidance/frame.hpp"

#include <stdexcept>
#include <utility>

namespace palpate::guidance {

MotionFrame::MotionFrame(const Pose& X_WF, scene::Motion motion) : X_WF_(X_WF), motion_(std::move(motion)) {}

FrameState MotionFrame::at(double t) const noexcept {
  const Pose X_WF = motion_.pose(X_WF_, t);
  return {X_WF, {motion_.velocity(X_WF.p, t), motion_.spin(t)}};
}

void LiveFrame::set(const FrameState& state) noexcept {
  const std::size_t n = told_.load(std::memory_order_relaxed) + 1;
  Slot& slot = slots_[n % kSlots];
  const auto put = [&slot](std::size_t from, const double* values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) slot[from + i].store(values[i], std::memory_order_relaxed);
  };
  std::atomic_thread_fence(std::memory_order_release);
  put(0, state.X_WF.R.data(), 9);
  put(9, state.X_WF.p.data(), 3);
  put(12, state.V_WF.v.data(), 3);
  put(15, state.V_WF.w.data(), 3);
  told_.store(n, std::memory_order_release);
}

FrameState LiveFrame::at(double) const noexcept {
  FrameState state;
  for (int again = 0; again < 4; ++again) {  // overtaken while it was read: once more
    const std::size_t n = told_.load(std::memory_order_acquire);
    if (n == 0) return {};
    const Slot& slot = slots_[n % kSlots];
    const auto get = [&slot](std::size_t from, double* values, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) values[i] = slot[from + i].load(std::memory_order_relaxed);
    };
    get(0, state.X_WF.R.data(), 9);
    get(9, state.X_WF.p.data(), 3);
    get(12, state.V_WF.v.data(), 3);
    get(15, state.V_WF.w.data(), 3);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (told_.load(std::memory_order_relaxed) - n < kSlots - 1) break;
  }
  return state;
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
