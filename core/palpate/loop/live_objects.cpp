#include "palpate/loop/live_objects.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "palpate/types/index.hpp"
#include "palpate/types/status.hpp"

namespace palpate::loop {
namespace {

/// Values of the signal tracked_status.
enum : int { kNotSeenYet = 0, kIsTracked = 1, kIsLost = 2 };

void scale(Material& to, const Material& from, double share) noexcept {
  to.K = share * from.K;
  to.B = share * from.B;
}

/// Gives `to` the share of the stiffness and damping of `from`, its regions included.
void scale(scene::Object& to, const scene::Object& from, double share) noexcept {
  scale(to.material, from.material, share);
  for (std::size_t i = 0; i < to.regions.size(); ++i) scale(to.regions[i].material, from.regions[i].material, share);
}

/// Places an object so that Object::pose and Motion::velocity are right at the approach's time and soon after.
void place(scene::Object& object, const scene::Approach& approach) noexcept {
  if (!object.live) return;
  object.X_WO = approach.X_WO();
  object.motion.V = approach.velocity();
  object.motion.about = object.X_WO * object.live->p_OC;
  object.motion.t0 = approach.t();
}

void write(const Pose& X, int slot, double* p, double* quat) noexcept {
  Vec3::Map(p + 3 * static_cast<std::ptrdiff_t>(slot)) = X.p;
  const Eigen::Quaterniond q(X.R);
  Eigen::Vector4d::Map(quat + 4 * static_cast<std::ptrdiff_t>(slot)) << q.w(), q.x(), q.y(), q.z();
}

}  // namespace

bool same_objects(const scene::Snapshot& a, const scene::Snapshot& b) noexcept {
  return std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(),
                    [](const scene::Object& x, const scene::Object& y) {
                      return x.name == y.name && x.surface->id() == y.surface->id() &&
                             x.live.has_value() == y.live.has_value();
                    });
}

int count_live(const scene::Snapshot& scene) noexcept {
  return static_cast<int>(std::count_if(scene.objects.begin(), scene.objects.end(),
                                        [](const scene::Object& object) { return object.live.has_value(); }));
}

void LiveObjects::reset(const scene::Snapshot& scene) noexcept {
  objects_ = frames_ = 0;
  started_ = false;
  for (const scene::Object& object : scene.objects) {
    if (object.live && objects_ < kMaxLive) approach_[to_index(objects_++)].reset(object.X_WO, 0.0);
  }
}

void LiveObjects::step(const LiveTargets& targets, RenderedScene& scene, double t) noexcept {
  int slot = 0;
  for (std::size_t i = 0; i < scene.objects.objects.size() && slot < objects_; ++i) {
    scene::Object& object = scene.objects.objects[i];
    if (!object.live) continue;
    const std::size_t k = to_index(slot++);
    scene::Approach& approach = approach_[k];
    if (!started_) approach.reset(approach.X_WO(), t);
    approach.step(targets.object[k], *object.live, t);
    place(object, approach);
    if (approach.share() != scene.share[k]) scale(object, scene.given->objects[i], scene.share[k] = approach.share());
  }
  started_ = true;
  frames_ = targets.frames;
  frame_ = targets.frame;
}

void LiveObjects::record(double t, Tick& tick) const noexcept {
  for (int i = 0; i < objects_; ++i) {
    const scene::Approach& approach = approach_[to_index(i)];
    write(approach.X_WO(), i, tick.live_p, tick.live_quat);
    tick.live_share[i] = approach.share();
    if (approach.lost()) tick.status |= kFrameLost;
  }
  for (int i = 0; i < frames_; ++i) {
    const TrackedFrame& frame = frame_[to_index(i)];
    write(frame.X_WF, i, tick.tracked_p, tick.tracked_quat);
    tick.tracked_age[i] = t - frame.t_seen;
    tick.tracked_status[i] = !std::isfinite(frame.t_seen) ? kNotSeenYet : frame.lost ? kIsLost : kIsTracked;
  }
}

}  // namespace palpate::loop
