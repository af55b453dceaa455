// Interface of surfaces that deform under the tool. Unlike all other surfaces, they have a state: each loop makes its
// own copies, and only its thread uses them.
#pragma once

#include <memory>
#include <span>

#include "palpate/types/spatial.hpp"

namespace palpate::scene {

class Surface;

/// Contact point of a sphere, in the surface's frame O.
struct SpherePlace {
  Vec3 p_OC = Vec3::Zero();    ///< contact point on the surface [m]
  Vec3 normal = Vec3::Zero();  ///< outward unit normal
  double depth = 0.0;          ///< penetration depth [m]
  double radius = 0.0;         ///< radius of the sphere [m]
  int sphere = 0;              ///< index of the sphere, to which the viscous memory of the contact belongs
};

/// Response of the surface to a sphere.
struct Response {
  double depth = 0.0;            ///< depth of the sphere in the surface as a whole; 0: no contact [m]
  Vec3 normal = Vec3::Zero();    ///< unit direction of the force without friction
  double force = 0.0;            ///< normal force on the sphere [N]
  double stiffness = 0.0;        ///< force / depth [N/m]
  double tangent = 0.0;          ///< d force / d depth [N/m]
  double stored = 0.0;           ///< energy stored near the contact, beside that of the body [J]
  Vec3 velocity = Vec3::Zero();  ///< velocity of the surface at the contact point, in O [m/s]
  bool carries = false;          ///< true: `carried` is known
  Vec3 carried = Vec3::Zero();   ///< mean motion of the points that hold the sphere, since the shape before, in O [m]
};

/// A contact that acts on the surface for one tick, in O.
struct SurfaceLoad {
  SpherePlace at;
  Vec3 force = Vec3::Zero();  ///< force on the tool at the beginning of the tick [N]
  /// What `force` has more once it has led over from the shape before. The surface answers the sum [N].
  Vec3 force_to_come = Vec3::Zero();
};

/// Energy and state of a deformable surface.
struct DeformableState {
  double potential = 0.0;  ///< stored by strain [J]
  double kinetic = 0.0;    ///< [J]
  bool hurried = false;    ///< true: it takes more time steps than usual, because it moves fast
  bool frozen = false;     ///< true: it diverged; its force goes to zero and returns by a ramp
  bool late = false;       ///< true: its thread has not finished in time; its surface stands still meanwhile
};

/// A surface with a state.
class Deformable {
 public:
  virtual ~Deformable() = default;
  Deformable(const Deformable&) = delete;
  Deformable& operator=(const Deformable&) = delete;
  /// A copy at rest, with the same Surface::id(). It allocates memory.
  [[nodiscard]] virtual std::shared_ptr<Surface> at_rest() const = 0;
  /// Response at a contact point. It changes nothing.
  [[nodiscard]] virtual Response respond(const SpherePlace& at) const noexcept = 0;
  /// Velocity of the surface near a point, in O [m/s].
  [[nodiscard]] virtual Vec3 velocity(const Vec3& p) const noexcept = 0;
  /// Advances by a tick under the contacts. They act as springs: their force follows the surface within the tick.
  virtual void advance(std::span<const SurfaceLoad> loads, double dt) noexcept = 0;
  [[nodiscard]] virtual DeformableState state() const noexcept = 0;
  /// Period by which the surface steps beside the cycle [s]; 0: it steps in advance().
  [[nodiscard]] virtual double period() const noexcept = 0;
  /// beside: another thread calls work() from now on; otherwise advance() does.
  virtual void set_beside(bool beside) noexcept = 0;
  /// Steps by a period if it is due. Returns true if it was. Nothing allocates, locks or throws.
  virtual bool work() noexcept = 0;
  /// Vertices of Surface::mesh() for drawing, 3 per vertex in O [m]. advance() publishes them at a limited rate. One
  /// thread beside that of the loop may call it; the result is valid until the next call.
  [[nodiscard]] virtual std::span<const double> published() noexcept = 0;

 protected:
  Deformable() = default;
};

}  // namespace palpate::scene
