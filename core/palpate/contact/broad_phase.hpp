// Broad phase: the objects of a scene that one sphere of the tool may have reached since they were last examined.
//
// An object that rests is examined again once the sphere has travelled as far as it was away from the object. The cost
// of a tick then depends on the objects near the tool, not on the number of objects in the scene.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/scene/snapshot.hpp"
#include "palpate/types/index.hpp"

namespace palpate::contact {

/// The objects that are due in a tick, in the order of the snapshot. Nothing allocates after the construction.
class BroadPhase {
 public:
  /// objects: largest number of objects in a scene.
  explicit BroadPhase(int objects) : wake_(to_index(objects)), due_(to_index(objects)) {}

  /// Makes all objects due.
  void reset() noexcept { revision_ = 0; }
  /// Calls visit(i) for each object that is due, with the sphere at p_W [m]. visit returns the distance that the sphere
  /// may travel before the object has to be examined again [m]; 0: in the next tick. Objects that move, deform, may be
  /// replaced or have no exact distance are due in each tick.
  template <class Visit>
  void step(const scene::Snapshot& scene, const Vec3& p_W, Visit&& visit) noexcept {
    begin(scene, p_W);
    int kept = 0;
    for (int k = 0; k < due_count_; ++k) {
      const int i = due_[to_index(k)];
      const double free = visit(i);
      if (free > kWorthwhile && revision_ != 0 && rests(scene.objects[to_index(i)])) {
        leave(i, free);
      } else {
        due_[to_index(kept++)] = i;
      }
    }
    due_count_ = kept;
  }
  /// Position of the sphere in the step before [m].
  [[nodiscard]] const Vec3& before() const noexcept { return before_; }
  /// Number of objects in the last step.
  [[nodiscard]] int objects() const noexcept { return objects_; }

 private:
  static constexpr double kWorthwhile = 1e-3;  // for a shorter way an object stays due [m]

  [[nodiscard]] static bool rests(const scene::Object& object) noexcept;
  void begin(const scene::Snapshot& scene, const Vec3& p_W) noexcept;
  void leave(int i, double free) noexcept;

  std::vector<double> wake_;  // way after which each object is due again; negative while it is due [m]
  std::vector<int> due_;      // the first due_count_ are due
  int due_count_ = 0, objects_ = 0;
  std::uint64_t revision_ = 0;  // of the snapshot in the step before
  double way_ = 0.0;            // way of the sphere in this snapshot [m]
  double soonest_ = 0.0;        // least of wake_ above way_ [m]
  Vec3 at_ = Vec3::Zero(), before_ = Vec3::Zero();
};

}  // namespace palpate::contact
