#include "palpate/scene/snapshot.hpp"

#include <algorithm>
#include <atomic>

namespace palpate::scene {

Snapshot with_own_deformables(Snapshot scene, const Snapshot* before) {
  for (Object& object : scene.objects) {
    const Deformable* const deformable = object.surface->deformable();
    if (deformable == nullptr) continue;
    const auto same = [&](const Object& other) { return other.surface->id() == object.surface->id(); };
    const Object* kept = nullptr;
    if (before != nullptr) {
      const auto found = std::find_if(before->objects.begin(), before->objects.end(), same);
      kept = found != before->objects.end() ? &*found : nullptr;
    }
    object.surface = kept != nullptr ? kept->surface : deformable->at_rest();
  }
  return scene;
}

void seal(Snapshot& scene) {
  static std::atomic<std::uint64_t> last{0};
  scene.revision = ++last;
  scene.soft.clear();
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].surface->deformable() != nullptr) scene.soft.push_back(i);
  }
}

}  // namespace palpate::scene
