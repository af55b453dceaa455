#include "palpate/loop/soft_threads.hpp"

#include <algorithm>

#include "palpate/scene/deformable.hpp"

namespace palpate::loop {
namespace {

constexpr double kPolls = 8.0;  // in a period: a thread looks for work so often
constexpr int kPriority = 70;   // SCHED_FIFO, below the loop's

scene::Deformable* stepped_beside(const scene::Surface& surface) noexcept {
  scene::Deformable* const soft = surface.deformable();
  return soft != nullptr && soft->period() > 0.0 ? soft : nullptr;
}

}  // namespace

void SoftThreads::start(const scene::Snapshot& rendered) {
  started_ = true;
  update(rendered);
}

void SoftThreads::update(const scene::Snapshot& rendered) {
  if (!started_) return;
  std::erase_if(running_, [&](Running& old) {
    const bool kept = std::any_of(rendered.objects.begin(), rendered.objects.end(),
                                  [&](const scene::Object& object) { return object.surface == old.surface; });
    if (!kept) old.thread->stop();  // the loop replaces the body in its next tick
    return !kept;
  });
  for (const scene::Object& object : rendered.objects) {
    scene::Deformable* const soft = stepped_beside(*object.surface);
    const bool runs = std::any_of(running_.begin(), running_.end(),
                                  [&](const Running& old) { return old.surface == object.surface; });
    if (soft == nullptr || runs) continue;
    const RealTimeOptions options{.allow_affinity = false, .priority = kPriority, .spin_us = 0.0};
    running_.push_back({object.surface, std::make_unique<RealTimeThread>(options)});
    soft->set_beside(true);
    running_.back().thread->start(kPolls / soft->period(), [soft](const Wake& wake) {
      soft->work();
      return !wake.stopping;
    });
  }
}

void SoftThreads::stop() {
  for (const Running& each : running_) {
    each.thread->stop();
    each.surface->deformable()->set_beside(false);
  }
  running_.clear();
  started_ = false;
}

}  // namespace palpate::loop
