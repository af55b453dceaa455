// Which copies of deformable surfaces a loop moves, for stages that were given the surfaces at rest.
#pragma once

#include "palpate/scene/snapshot.hpp"

namespace palpate::scene {

/// While it lives, queries of the calling thread see the surfaces of `scene` as they are deformed. Other threads, such
/// as one that draws a fixture, see the shapes at rest. Nothing allocates or locks.
class DeformedScope {
 public:
  explicit DeformedScope(const Snapshot& scene) noexcept;
  ~DeformedScope();
  DeformedScope(const DeformedScope&) = delete;
  DeformedScope& operator=(const DeformedScope&) = delete;

  /// The surface with the id of `surface` in the scene of the present scope; without one, `surface` itself.
  [[nodiscard]] static const Surface& present(const Surface& surface) noexcept;
  static const Surface& present(Surface&& surface) = delete;  // it would dangle

 private:
  const Snapshot* before_;
};

}  // namespace palpate::scene
