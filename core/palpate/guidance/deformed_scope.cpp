#include "palpate/guidance/deformed_scope.hpp"

namespace palpate::guidance {
namespace {

// The model initial-exec needs no allocation at the first use in a thread.
[[gnu::tls_model("initial-exec")]] thread_local const scene::Snapshot* deformed = nullptr;

}  // namespace

DeformedScope::DeformedScope(const scene::Snapshot& scene) noexcept : before_(deformed) { deformed = &scene; }

DeformedScope::~DeformedScope() { deformed = before_; }

const scene::Surface& DeformedScope::present(const scene::Surface& surface) noexcept {
  if (deformed == nullptr) return surface;
  for (const scene::Object& object : deformed->objects) {
    if (object.surface->id() == surface.id()) return *object.surface;
  }
  return surface;
}

}  // namespace palpate::guidance
