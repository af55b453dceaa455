#include "palpate/scene/deformed_scope.hpp"

namespace palpate::scene {
namespace {

// The model initial-exec needs no allocation at the first use in a thread.
[[gnu::tls_model("initial-exec")]] thread_local const Snapshot* deformed = nullptr;

}  // namespace

DeformedScope::DeformedScope(const Snapshot& scene) noexcept : before_(deformed) { deformed = &scene; }

DeformedScope::~DeformedScope() { deformed = before_; }

const Surface& DeformedScope::present(const Surface& surface) noexcept {
  if (deformed == nullptr) return surface;
  for (const Object& object : deformed->objects) {
    if (object.surface->id() == surface.id()) return *object.surface;
  }
  return surface;
}

}  // namespace palpate::scene
