#include "palpate/scene/snapshot.hpp"

#include <algorithm>

#include "palpate/scene/deformable.hpp"

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

}  // namespace palpate::scene
