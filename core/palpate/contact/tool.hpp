// The whole tool: the spherical proxy region (SPR) on the tip, and more spheres along jaws and shaft.
//
// Each sphere has a contact method of its own, which knows nothing of the others; here their contacts become one set,
// and learn what all methods would have to tell alike: how the object feels there and how fast its surface moves.
#pragma once

#include <array>
#include <memory>
#include <string_view>
#include <vector>

#include "palpate/contact/contact.hpp"

namespace palpate::contact {

/// Spheres of a tool, at most; the SPR on the tip is the first.
inline constexpr int kMaxSpheres = 16;

class Tool {
 public:
  /// method: of every sphere (make_method). Throws std::invalid_argument naming what cannot be.
  Tool(std::string_view method, const Options& options);
  Tool(const Tool&) = delete;
  Tool& operator=(const Tool&) = delete;

  /// How many spheres: 1 + options.spheres.
  [[nodiscard]] int size() const noexcept { return static_cast<int>(methods_.size()); }
  /// p_WS: centre of each sphere in W, the first is the tip T [m]; t [s]. When more touch than a set can hold, the
  /// strongest are kept.
  const ContactSet& step(const scene::Snapshot& scene, const Vec3* p_WS, double t) noexcept;

  // As of Method, for all of them.
  void reset() noexcept;
  [[nodiscard]] bool asynchronous() const noexcept { return methods_.front()->asynchronous(); }
  void collide(const scene::Snapshot& scene);
  void check(const scene::Snapshot& scene) const { methods_.front()->check(scene); }

 private:
  void complete(Contact& contact, const scene::Object& object, double t) const noexcept;
  void keep_if_stronger(const Contact& contact) noexcept;

  std::vector<std::unique_ptr<Method>> methods_;
  bool real_;
  std::array<double, kMaxSpheres> radius_{};
  std::array<Vec3, kMaxSpheres> last_;  ///< p_WS of the previous step
  double t_ = 0.0;
  bool running_ = false;
  ContactSet set_;
  Contact spare_;
};

}  // namespace palpate::contact
