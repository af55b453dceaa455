// The scene as the loop renders it: a copy of the snapshot, in which live objects are at their present pose.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "palpate/loop/tick.hpp"
#include "palpate/scene/approach.hpp"
#include "palpate/scene/snapshot.hpp"
#include "palpate/types/live.hpp"

namespace palpate::loop {

/// A snapshot with the copy that the loop may change.
struct RenderedScene {
  std::shared_ptr<const scene::Snapshot> given;  ///< as it was set
  scene::Snapshot objects;                       ///< copy with the present poses and materials of live objects
  std::uint64_t epoch = 0;                       ///< grows whenever a scene with other objects is set

  /// Copies the snapshot; allocates memory.
  /// Its soft bodies are those of `before` that have the same id, or else copies at rest.
  RenderedScene(std::shared_ptr<const scene::Snapshot> snapshot, std::uint64_t number,
                const scene::Snapshot* before = nullptr)
      : given(std::move(snapshot)), objects(scene::with_own_deformables(*given, before)), epoch(number) {
    scene::seal(objects);
    share.fill(1.0);
  }

  std::array<double, kMaxLive> share{};  ///< share of its force with which each live object is in `objects`
};

/// True if both scenes have the same number of objects, with the same names and surfaces: contact then stays valid.
[[nodiscard]] bool same_objects(const scene::Snapshot& a, const scene::Snapshot& b) noexcept;
/// Number of live objects.
[[nodiscard]] int count_live(const scene::Snapshot& scene) noexcept;

/// Motion of all live objects. Nothing allocates, locks or throws.
class LiveObjects {
 public:
  /// Starts anew with the live objects of a scene, at rest.
  void reset(const scene::Snapshot& scene) noexcept;
  /// Moves the live objects to the time t [s], and writes their pose, motion and material to scene.objects. Without
  /// targets of this scene they stay where they are.
  void step(const LiveTargets& targets, RenderedScene& scene, double t) noexcept;
  /// Writes the signals of the stage `tracking`, and the status bit of a lost object.
  void record(double t, Tick& tick) const noexcept;

 private:
  std::array<scene::Approach, kMaxLive> approach_;
  std::array<TrackedFrame, kMaxLive> frame_;
  int objects_ = 0, frames_ = 0;
  bool started_ = false;  ///< true once targets have been set
};

}  // namespace palpate::loop
