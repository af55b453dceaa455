#include "palpate/scene/surface.hpp"

#include <atomic>

namespace palpate::scene {

Surface::Surface() {
  static std::atomic<std::uint64_t> made{0};
  id_ = ++made;
}

}  // namespace palpate::scene
