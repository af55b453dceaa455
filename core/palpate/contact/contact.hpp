// Stage `contact`: finds where the tool touches the surfaces, how deep it is, and which direction leads outside.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/scene/snapshot.hpp"
#include "palpate/types/contact.hpp"
#include "palpate/types/spatial.hpp"

namespace palpate::contact {

/// A sphere of the tool, in addition to the SPR at its tip.
struct ToolSphere {
  int link = -1;  ///< index of the follower link that carries the sphere (arm::Arm::link_names); -1: the tool tip T
  Vec3 p = Vec3::Zero();      ///< centre of the sphere in the frame of the link, with closed jaws [m]
  double radius = 0.002;      ///< radius of the sphere [m]
  Vec3 hinge = Vec3::Zero();  ///< point on the axis of a jaw, in the frame of the link [m]
  Vec3 axis = Vec3::Zero();   ///< axis of a jaw times rotation per jaw angle, in the link's frame; zero: no jaw [-]

  /// Centre of the sphere in the frame of the link, for the jaw angle `jaw` [rad].
  [[nodiscard]] Vec3 centre(double jaw) const noexcept;
  /// Motion of the centre per jaw angle, in the frame of the link [m/rad].
  [[nodiscard]] Vec3 motion(double jaw) const noexcept { return axis.cross(centre(jaw) - hinge); }
};

/// ToolSphere::link of a sphere on an object that the jaws carry; it touches nothing while they carry none.
inline constexpr int kCarried = -2;

/// Options of the stage.
struct Options {
  double radius = 0.002;        ///< radius of the SPR [m]
  double release = 0.05;        ///< `proxy`: deflection that releases a tool that passed through a closed object [m]
  double collision_rate = 250;  ///< rate of the collision thread, for the paper's methods [Hz]
  std::vector<ToolSphere> spheres{};  ///< spheres of the tool in addition to the SPR
  int objects = 32;                   ///< largest number of objects in a scene, at most scene::kMaxObjects
  int sphere = 0;                     ///< index of the sphere that a method is for; Tool sets it
  bool real_objects = false;          ///< true: the tool touches the real objects instead of the virtual ones
};

/// Interface of a contact method for one sphere. A method may have a state, for example the side from which the sphere
/// came. step() must not allocate.
class Method {
 public:
  virtual ~Method() = default;
  /// Discards the state: the next step() assumes that the tool came from outside.
  virtual void reset() noexcept = 0;
  /// Finds the contacts at time t [s], with all objects at their pose Object::pose(t). p_WT: centre of the sphere (the
  /// tool tip for the SPR) [m]; v_WT: its velocity [m/s]; both in W.
  virtual const ContactSet& step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT,
                                 double t) noexcept = 0;

  /// True if the contacts of the method get Coulomb friction (friction.hpp).
  [[nodiscard]] virtual bool has_friction() const noexcept { return false; }
  /// True if an anisotropic stiffness acts along the axes of W, as in Eq 8. On a slope this force has no potential. The
  /// other methods take n^T K n along the normal.
  [[nodiscard]] virtual bool stiff_along_axes() const noexcept { return false; }

  /// For verification only, because it allocates: each step appends the positions through which the proxies move to
  /// `path`, in the frames of their objects [m]. A null pointer ends the recording. A method that does not record is
  /// assumed to move its proxies in straight lines.
  virtual void record_path(std::vector<Vec3>* /*path*/) {}

  /// True for a method whose collision detection allocates and cannot run in step(). step() then posts a request, and
  /// collide() answers it. The owner of the loop calls collide(): after each step() in lockstep, and in a separate
  /// thread in real time, several times per collision period. Without a new request it computes nothing.
  [[nodiscard]] virtual bool asynchronous() const noexcept { return false; }
  /// Answers the last request of step(). It must not be called in the cycle, because it allocates, may take long and
  /// may throw. One thread at a time may call it and keeps `scene` alive; step() may run at the same time. The first
  /// call prepares the meshes of the scene, so it should happen before the loop starts.
  virtual void collide(const scene::Snapshot& /*scene*/) {}
  /// Throws std::invalid_argument with the name of an object that this method cannot handle. It must not be called in
  /// the cycle.
  virtual void check(const scene::Snapshot& /*scene*/) const {}
};

/// Names of all contact methods, the default first.
std::vector<std::string> methods();
/// Makes the contact method `name`. Throws std::invalid_argument for an unknown name, with the known names, and for
/// invalid options.
std::unique_ptr<Method> make_method(std::string_view name, const Options& options);

}  // namespace palpate::contact
