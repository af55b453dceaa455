// Contacts of the whole tool: the spherical proxy region (SPR) at the tip, and additional spheres along jaws and shaft.
//
// Each sphere has its own contact method, independent of the others. This class merges their contacts into one set and
// adds what is common to all methods: the material of the object, the velocity of its surface at the contact point, and
// friction.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "palpate/contact/contact.hpp"
#include "palpate/contact/friction.hpp"
#include "palpate/types/spring_rest.hpp"

namespace palpate::contact {

/// Maximum number of spheres of a tool, including the SPR at the tip, which is the first.
inline constexpr int kMaxSpheres = 16;

/// Contact detection for all spheres of the tool.
class Tool {
 public:
  /// method: name of the contact method of every sphere (make_method). Throws std::invalid_argument with the name of an
  /// invalid option.
  Tool(std::string_view method, const Options& options);
  Tool(const Tool&) = delete;
  Tool& operator=(const Tool&) = delete;

  /// Radius of sphere s [m].
  [[nodiscard]] double radius(int s) const noexcept { return radius_[static_cast<std::size_t>(s)]; }
  /// Number of spheres: 1 + options.spheres.size().
  [[nodiscard]] int size() const noexcept { return static_cast<int>(methods_.size()); }
  /// Finds the contacts at time t [s]. p_WS: centres of the size() spheres in W, the tip T first [m]. If there are more
  /// contacts than a set can hold, the strongest are kept.
  const ContactSet& step(const scene::Snapshot& scene, const Vec3* p_WS, double t) noexcept;
  /// Part of the tip's motion since the last step that the hand has not made (displacement, rotation vector), in W: the
  /// next step takes it for a jump, whose work no spring stores.
  void jump(const Twist& jump) noexcept { jump_ = jump; }

  // The following functions apply the function of Method with the same name to all spheres.
  void reset() noexcept;
  [[nodiscard]] bool asynchronous() const noexcept { return methods_.front()->asynchronous(); }
  void collide(const scene::Snapshot& scene);
  void check(const scene::Snapshot& scene) const;

 private:
  /// Friction of a sphere on an object, and the tick in which they last touched. All vectors are in O [m].
  struct Rubbing {
    Friction friction;
    std::uint64_t surface = 0;
    std::uint64_t tick = 0;
    bool rubs = false;         ///< false: without friction in that tick
    Vec3 x = Vec3::Zero();     ///< centre of the sphere in that tick
    Vec3 felt = Vec3::Zero();  ///< lag in that tick
    // For a surface that steps beside the cycle:
    Vec3 rate = Vec3::Zero();      ///< motion of the surface for each tick of its last period
    Vec3 step = Vec3::Zero();      ///< motion that it is taken to have made in this tick
    Vec3 foreseen = Vec3::Zero();  ///< sum of these motions since its last shape
    Vec3 to_come = Vec3::Zero();   ///< part of the friction's lag that is not felt yet
    int leading = 0;               ///< ticks until it is felt
  };
  /// Spring of a sphere on an object, which a jump of the surface does not load, in the tick of their last contact.
  struct Spring {
    SpringRest rest;
    const scene::Surface* surface = nullptr;
    std::uint64_t tick = 0;
    Vec3 x = Vec3::Zero();  ///< centre of the sphere, in O [m]
    Vec3 F = Vec3::Zero();  ///< its whole force, in O [N]
  };
  /// Centre [m] and contact normal of a sphere, in O.
  struct SphereMotion {
    Vec3 x, normal;
  };

  void complete(Contact& contact, const scene::Object& object, double t) const noexcept;
  void press_along_normal(Contact& contact) const noexcept;
  void rub(Contact& contact, const Vec3& p_WS, const scene::Object& object, double t) noexcept;
  void keep_energy(Contact& contact, const Vec3& p_WS, const scene::Object& object, double t) noexcept;
  static Vec3 follow(Rubbing& state, const Vec3& shape, const Vec3& x, int ticks) noexcept;
  static Vec3 lead(Rubbing& state, const Contact& contact, const SphereMotion& sphere, const Vec3& lag,
                   int ticks) noexcept;
  void respond(Contact& contact, const scene::Object& object, double t) const noexcept;
  void keep_if_stronger(const Contact& contact) noexcept;

  std::vector<std::unique_ptr<Method>> methods_;
  std::vector<Rubbing> rubbing_;  ///< objects_ for each sphere; none for a method without friction
  std::vector<Spring> springs_;   ///< as rubbing_
  std::uint64_t tick_ = 1;        ///< number of this step
  bool real_objects_;
  int objects_;  ///< largest number of objects in a scene
  std::array<double, kMaxSpheres> radius_{};
  std::array<Vec3, kMaxSpheres> last_;  ///< p_WS of the previous step [m]
  double t_ = 0.0;
  Twist jump_;  ///< motion of the tip that the hand has not made (displacement, rotation vector)
  bool running_ = false;
  ContactSet set_;
  Contact spare_;
};

}  // namespace palpate::contact
