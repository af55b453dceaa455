// Stage `contact`: where is the tool relative to the surface, and which way is out?
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/scene/snapshot.hpp"
#include "palpate/types/contact.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// A sphere of the tool beside the SPR on its tip.
struct Sphere {
  int link = -1;              ///< of the follower it is fixed to (arm::Arm::link_names); below zero: the tool tip T
  Vec3 p = Vec3::Zero();      ///< its centre in that link's frame, jaws closed [m]
  double radius = 0.002;      ///< [m]
  Vec3 hinge = Vec3::Zero();  ///< of a jaw: a point on its axis, in the link's frame [m]
  Vec3 turn = Vec3::Zero();   ///< of a jaw: axis times how far it turns per jaw angle, in the link's frame [-]

  /// Its centre in the link's frame with the jaws open by `jaw` [rad].
  [[nodiscard]] Vec3 centre(double jaw) const noexcept;
};

struct Options {
  double radius = 0.002;        ///< SPR radius [m]
  double release = 0.05;        ///< `proxy`: deflection at which a tool that went through a closed object is free [m]
  double collision_rate = 250;  ///< rate of the collision thread of the paper's methods [Hz]
  std::vector<Sphere> spheres;  ///< of the tool beside the SPR
  bool real = false;            ///< touches the objects that are real, in place of the virtual ones
};

/// One way of finding contacts of one sphere. Has a memory (which side it came from), none of it on the heap in step().
class Method {
 public:
  virtual ~Method() = default;
  /// Forget the past: the tool is where it is, outside.
  virtual void reset() noexcept = 0;
  /// p_WT: the sphere's centre, of the SPR: the tool tip [m]; v_WT [m/s]; t [s]: objects are where Object::pose(t) is.
  virtual const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT,
                                 double t) noexcept = 0;

  /// For judges, never in a loop: each step appends the places that the proxies pass through, in their objects' frames,
  /// to `path`; null ends it. A method without a path of its own goes straight from proxy to proxy.
  virtual void watch(std::vector<Vec3>* /*path*/) {}

  /// True for a method whose geometry allocates, so that it cannot be done in step(): step() leaves a request behind
  /// and collide() answers it. Whoever drives the loop calls collide(): right after each step() in lockstep and in a
  /// rendered path, a thread of its own in real time (a few times per collision period; nothing asked, nothing done).
  [[nodiscard]] virtual bool asynchronous() const noexcept { return false; }
  /// Never from the cycle: allocates, may take long, may throw. One caller at a time, which keeps `scene` alive; step()
  /// may run meanwhile. The first call prepares the scene's meshes: call it once before the loop starts.
  virtual void collide(const scene::Snapshot& /*scene*/) {}
  /// Throws std::invalid_argument naming the object of a scene that this method cannot feel. Not from the cycle.
  virtual void check(const scene::Snapshot& /*scene*/) const {}
};

/// Names of the methods there are; the default first.
std::vector<std::string> methods();
/// Throws std::invalid_argument naming the methods there are.
std::unique_ptr<Method> make_method(std::string_view name, const Options& options);

}  // namespace palpate::contact
