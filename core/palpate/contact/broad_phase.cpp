#include "palpate/contact/broad_phase.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace palpate::contact {
namespace {

constexpr double kMargin = 1e-6;  // of a distance, for the rounding of a long way [m]
constexpr double kDue = -1.0;

}  // namespace

bool BroadPhase::rests(const scene::Object& object) noexcept {
  const scene::Surface& surface = *object.surface;
  return object.motion.is_static() && !object.live && surface.deformable() == nullptr && surface.is_exact();
}

void BroadPhase::begin(const scene::Snapshot& scene, const Vec3& p_W) noexcept {
  const double moved = (p_W - at_).norm();
  before_ = at_;
  at_ = p_W;
  if (scene.revision == 0 || scene.revision != revision_) {
    revision_ = scene.revision;
    objects_ = due_count_ = std::min(static_cast<int>(scene.objects.size()), static_cast<int>(wake_.size()));
    std::fill(wake_.begin(), wake_.end(), kDue);
    std::iota(due_.begin(), due_.begin() + due_count_, 0);
    way_ = 0.0;
    soonest_ = std::numeric_limits<double>::infinity();
    return;
  }
  way_ += moved;
  if (way_ < soonest_) return;
  soonest_ = std::numeric_limits<double>::infinity();
  due_count_ = 0;
  for (int i = 0; i < objects_; ++i) {
    double& wake = wake_[to_index(i)];
    if (wake <= way_) {
      wake = kDue;
      due_[to_index(due_count_++)] = i;
    } else {
      soonest_ = std::min(soonest_, wake);
    }
  }
}

void BroadPhase::leave(int i, double free) noexcept {
  wake_[to_index(i)] = way_ + free - kMargin;
  soonest_ = std::min(soonest_, wake_[to_index(i)]);
}

}  // namespace palpate::contact
