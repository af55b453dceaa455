#include "palpate/loop/front.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <stdexcept>
#include <utility>

#include "palpate/scene/deformable.hpp"

namespace palpate::loop {
namespace {

constexpr double kRingSeconds = 4.0;  // [s] delay of a recorder that the queue can buffer
constexpr double kPollShare = 0.25;   // pause of the collider between two polls, as a fraction of a collision period

std::shared_ptr<const scene::Snapshot> present(std::shared_ptr<const scene::Snapshot> scene) {
  if (!scene) throw std::invalid_argument("scene: none given; a Snapshot without objects is free space");
  if (count_live(*scene) > kMaxLive) {
    throw std::invalid_argument("scene: " + std::to_string(count_live(*scene)) + " live objects; at most " +
                                std::to_string(kMaxLive) + " are possible");
  }
  return scene;
}

}  // namespace

void check(const Controls& controls) {
  if (!(controls.guidance >= 0.0 && controls.guidance <= 1.0)) {
    throw std::invalid_argument("controls: guidance = " + std::to_string(controls.guidance) + " must lie in 0..1");
  }
  if (!(controls.scale >= 0.0 && controls.scale <= 10.0)) {
    throw std::invalid_argument("controls: scale = " + std::to_string(controls.scale) +
                                " must be above 0 and at most 10, or 0 for that of the scene");
  }
  if (!controls.quat_WL.isZero() && !(std::abs(controls.quat_WL.norm() - 1.0) < 1e-6)) {
    throw std::invalid_argument("controls: quat_WL must be a unit quaternion w x y z, or zero for that of the scene");
  }
  if (!(controls.stiffness_scale >= 0.0 && std::isfinite(controls.stiffness_scale)) ||
      !(controls.damping_scale >= 0.0 && std::isfinite(controls.damping_scale)) ||
      !controls.p_hand_offset_W.allFinite()) {
    throw std::invalid_argument(
        "controls: stiffness_scale and damping_scale must be 0 or more, p_hand_offset_W finite");
  }
}

Front::Front(contact::Tool& contact, std::shared_ptr<const scene::Snapshot> scene, double rate,
             const guidance::Options& guidance)
    : contact_(contact),
      newest_scene_(present(std::move(scene))),
      scene_(std::make_shared<RenderedScene>(newest_scene_, 0)),
      newest_rendered_(scene_.current().objects),
      guidance_(guidance),
      dt_(1.0 / rate),
      fixtures_(std::make_shared<const guidance::ActiveFixtures>(
          guidance::ActiveFixtures{std::make_shared<const guidance::FixtureList>(), nullptr})),
      motion_(std::make_shared<const PlannedMotion>()),
      ring_(static_cast<std::size_t>(kRingSeconds * rate), false) {
  contact_.check(*newest_scene_);
  live_.reset(*newest_scene_);
}

Controls Front::controls() const {
  const std::lock_guard lock(callers_);
  return controls_;
}

void Front::set_controls(const Controls& controls) {
  check(controls);
  const std::lock_guard lock(callers_);
  controls_ = controls;
  controls_in_.write(controls);
}

void Front::set_scene(std::shared_ptr<const scene::Snapshot> scene) {
  present(scene);
  contact_.check(*scene);
  const std::lock_guard lock(callers_);
  if (!same_objects(*newest_scene_, *scene)) ++newest_epoch_;
  newest_scene_ = scene;
  auto rendered = std::make_shared<RenderedScene>(std::move(scene), newest_epoch_, &newest_rendered_);
  newest_rendered_ = rendered->objects;
  soft_threads_.update(newest_rendered_);
  scene_.publish(std::move(rendered));
}

void Front::set_live(LiveTargets targets) {
  const std::lock_guard lock(callers_);
  if (const int live = count_live(*newest_scene_); targets.objects != live) {
    throw std::invalid_argument("live: " + std::to_string(targets.objects) + " targets for " + std::to_string(live) +
                                " live objects; give one for each, in the order of the snapshot");
  }
  targets.epoch = newest_epoch_;
  targets_in_.write(targets);
}

bool Front::take_scene(double t) noexcept {
  const bool fresh = scene_.update();
  RenderedScene& scene = scene_.current();
  const bool other = fresh && scene.epoch != epoch_;
  if (other) {
    epoch_ = scene.epoch;
    live_.reset(scene.objects);
  }
  const LiveTargets& targets = targets_in_.read();
  if (targets.objects > 0 && targets.epoch == epoch_) live_.step(targets, scene, t);
  return other;
}

void Front::set_fixtures(std::shared_ptr<const guidance::FixtureList> fixtures) {
  if (!fixtures) throw std::invalid_argument("guidance: no fixtures given; an empty list is none");
  fixtures->check();
  const std::lock_guard lock(callers_);
  if (!stage_) stage_ = fixtures->make_stage(guidance_, dt_);
  fixtures_.publish(
      std::make_shared<const guidance::ActiveFixtures>(guidance::ActiveFixtures{std::move(fixtures), stage_}));
}

std::uint64_t Front::execute(PlannedMotion motion, ExecutionOrder order) {
  check(motion);
  check(order);
  const std::lock_guard lock(callers_);
  motion.number = order.motion = ++motions_;
  order_in_.write(order);
  motion_.publish(std::make_shared<const PlannedMotion>(std::move(motion)));
  return order.motion;
}

void Front::set_order(const ExecutionOrder& order) {
  check(order);
  const std::lock_guard lock(callers_);
  order_in_.write(order);
}

Tick Front::latest() {
  const std::lock_guard lock(callers_);
  return latest_.read();
}

std::vector<double> Front::soft_vertices(std::size_t object) {
  const std::lock_guard lock(callers_);
  const auto& objects = newest_rendered_.objects;
  scene::Deformable* const soft = object < objects.size() ? objects[object].surface->deformable() : nullptr;
  if (soft == nullptr) {
    throw std::invalid_argument("soft_vertices: object " + std::to_string(object) + " of " +
                                std::to_string(objects.size()) + " does not exist or is not soft");
  }
  const std::span<const double> vertices = soft->published();
  return {vertices.begin(), vertices.end()};
}

std::size_t Front::drain(std::size_t n, Tick* rows) {
  const std::lock_guard lock(callers_);
  std::size_t done = 0;
  while (done < n && ring_.pop(rows[done])) ++done;
  return done;
}

void Front::start_threads(double collision_rate) {
  {
    const std::lock_guard lock(callers_);
    soft_threads_.start(newest_rendered_);
  }
  if (!contact_.asynchronous()) return;
  const double pause = kPollShare / std::max(collision_rate, 1.0);
  collider_.start([this] { collide(); }, std::chrono::microseconds(static_cast<std::int64_t>(1e6 * pause)));
}

void Front::stop_threads() {
  collider_.stop();
  const std::lock_guard lock(callers_);
  soft_threads_.stop();
}

void Front::collide() {
  if (!contact_.asynchronous()) return;
  std::shared_ptr<const scene::Snapshot> scene;
  {
    const std::lock_guard lock(callers_);
    scene = newest_scene_;
  }
  contact_.collide(*scene);
}

}  // namespace palpate::loop
