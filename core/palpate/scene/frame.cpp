#include "palpate/scene/frame.hpp"

#include <Eigen/Geometry>
#include <utility>

#include "palpate/types/so3.hpp"

namespace palpate::scene {
namespace {

constexpr double kMaxInterval = 0.2;  // [s] poses that far apart in time yield no velocity

}  // namespace

MotionFrame::MotionFrame(const Pose& X_WF, Motion motion) : X_WF_(X_WF), motion_(std::move(motion)) {}

FrameState MotionFrame::at(double t) const noexcept {
  const Pose X_WF = motion_.pose(X_WF_, t);
  return {X_WF, {motion_.velocity(X_WF.p, t), motion_.angular_velocity(t)}};
}

void LiveFrame::put(const FrameState& state, bool with_velocity) noexcept {
  const std::size_t n = updates_.load(std::memory_order_relaxed) + 1;
  Slot& slot = slots_[n % kSlots];
  const auto put = [&slot](std::size_t from, const double* values, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) slot[from + i].store(values[i], std::memory_order_relaxed);
  };
  std::atomic_thread_fence(std::memory_order_release);
  const double given = with_velocity ? 1.0 : 0.0;
  put(0, state.X_WF.R.data(), 9);
  put(9, state.X_WF.p.data(), 3);
  put(12, state.V_WF.v.data(), 3);
  put(15, state.V_WF.w.data(), 3);
  put(18, &given, 1);
  updates_.store(n, std::memory_order_release);
}

// Reads the newest state. Returns true if its velocity was given; also before the first pose, whose velocity is zero.
bool LiveFrame::get(FrameState& state) const noexcept {
  double given = 0.0;
  for (int again = 0; again < 4; ++again) {  // reads again if the slot was overwritten meanwhile
    const std::size_t n = updates_.load(std::memory_order_acquire);
    if (n == 0) return true;
    const Slot& slot = slots_[n % kSlots];
    const auto get = [&slot](std::size_t from, double* values, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) values[i] = slot[from + i].load(std::memory_order_relaxed);
    };
    get(0, state.X_WF.R.data(), 9);
    get(9, state.X_WF.p.data(), 3);
    get(12, state.V_WF.v.data(), 3);
    get(15, state.V_WF.w.data(), 3);
    get(18, &given, 1);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (updates_.load(std::memory_order_relaxed) - n < kSlots - 1) break;
  }
  return given != 0.0;
}

FrameState LiveFrame::at(double) const noexcept {
  FrameState state;
  if (!get(state)) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      state.V_WF.v[k] = V_[i].load(std::memory_order_relaxed);
      state.V_WF.w[k] = V_[i + 3].load(std::memory_order_relaxed);
    }
  }
  return state;
}

void LiveFrame::see(double t) noexcept {
  const std::size_t updates = updates_.load(std::memory_order_acquire);
  Twist V;
  if (t < t_) seen_ = 0;  // time went back: a new run
  if (updates == seen_) {
    t_ = t;
    if (age() <= 2.5 * interval_) return;  // the next pose is not yet overdue; once it is, the frame has stopped
  } else {
    FrameState now;
    (void)get(now);
    interval_ = seen_ > 0 ? t - t_update_ : 0.0;
    const bool often = interval_ > 0.0 && interval_ < kMaxInterval;
    const Vec3 turned = rotation_vector(now.X_WF.R * X_seen_.R.transpose());
    if (often) V = {(now.X_WF.p - X_seen_.p) / interval_, turned / interval_};
    const bool follows = often && V.v.norm() <= kMaxSpeed && V.w.norm() <= kMaxTurnRate;
    const bool jumped = !follows && (now.X_WF.p != X_seen_.p || now.X_WF.R != X_seen_.R);
    if (jumped) V = {}, t_jump_ = t;
    X_seen_ = now.X_WF;
    seen_ = updates;
    t_ = t_update_ = t;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    V_[i].store(V.v[k], std::memory_order_relaxed);
    V_[i + 3].store(V.w[k], std::memory_order_relaxed);
  }
}

}  // namespace palpate::scene
