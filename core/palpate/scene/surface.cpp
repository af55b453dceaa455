#include "palpate/scene/surface.hpp"

#include <atomic>

namespace palpate::scene {

Surface::Surface(std::uint64_t continues) : id_(continues) {
  static std::atomic<std::uint64_t> made{0};
  if (id_ == 0) id_ = ++made;
}

}  // namespace palpate::scene
