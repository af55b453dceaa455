// The proxy of one mesh: a sphere that stays outside the mesh while the tool goes in.
//
// The centre c of the proxy is at least the sphere's radius r away from every triangle. In each tick c moves as near to
// the tool g as possible without crossing the surface,
//
//   c = argmin |c - g|   subject to   n_i . (c - q_i) >= r,      delta = c - g,
//
// where q_i is the point of triangle i nearest to the proxy and n_i = (c - q_i) / |c - q_i|. A triangle is convex, so a
// sphere with its centre in half-space i does not intersect triangle i. The position of the proxy remembers which side
// is outside; the winding of the surface is not used. The force is therefore right at any depth, behind thin plates and
// past the medial axis. Faces, convex edges (rounded by r), concave edges and corners correspond to one, two or three
// active half-spaces.
//
// Where the mesh is smooth, a smooth surface replaces the facet (scene/smooth.hpp): the force uses its normal through
// the tool and the distance along this normal. The reference is F = k (r - phi) n with the signed distance phi.
//
// Release: the proxy also stays on its side when the tool has passed through the object, so that a thin plate holds.
// The proxy is released when the tool has certainly passed through: the object is closed, the tool's sphere is outside
// and clear of it, and the deflection exceeds `release`, which corresponds to a force that no device renders.
//
// If the tool starts inside a closed object, or an object appears around the tool, the proxy starts at the nearest
// point outside. started_inside() is true until the tool is free. Open surfaces can be touched from both sides.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "palpate/contact/half_spaces.hpp"
#include "palpate/scene/mesh_impl.hpp"

namespace palpate::contact {

/// Proxy of one mesh. All vectors are expressed in the object's frame O.
class ObjectProxy {
 public:
  /// Contact of the proxy, without friction.
  struct ProxyContact {
    bool touching = false;       ///< true while the tool is in contact
    Vec3 delta = Vec3::Zero();   ///< deflection p_proxy - p_tool [m]
    Vec3 normal = Vec3::Zero();  ///< unit normal, points out of the object
    double depth = 0.0;          ///< penetration depth, delta . normal [m]
    double stretch = 0.0;        ///< the contact stores 1/2 k stretch^2 [m]
  };

  /// Discards the state: the next step() places the proxy anew.
  void reset() noexcept { mesh_ = nullptr; }
  /// Moves the proxy towards the tool at g [m] and returns the contact. radius: radius of the sphere [m]. release:
  /// deflection that releases a tool that has passed through a closed object [m].
  ProxyContact step(const scene::Mesh& mesh, const Vec3& g, double radius, double release) noexcept;
  /// Distance that a free tool, which is at g [m], may move before step() does more than follow it [m]; 0 unless free.
  [[nodiscard]] double free_way(const Vec3& g, double radius) noexcept;
  /// Lets the proxy follow a free tool to g [m] without a step, within free_way().
  void follow(const Vec3& g) noexcept { centre_ = tool_ = g; }
  /// Derivative of the normal of the last step's contact with the tool's position g [1/m].
  [[nodiscard]] Mat3 normal_gradient(const Vec3& normal, const Vec3& g, double radius) const noexcept;
  /// Motion of the proxy with its surface at the beginning of the last step, where the mesh moved [m].
  [[nodiscard]] const Vec3& carried() const noexcept { return carried_; }
  /// For verification: appends every position of the centre to `path` (Method::record_path).
  void record_path(std::vector<Vec3>* path) noexcept { path_ = path; }
  /// True if the proxy started with the tool inside the object, until the tool is free.
  [[nodiscard]] bool started_inside() const noexcept { return started_inside_; }

 private:
  /// Constraint of the proxy by one triangle: the nearest point of the triangle, as surface coordinates and as position
  /// q [m].
  struct Constraint {
    scene::SurfacePoint at;
    Vec3 q = Vec3::Zero();
  };

  /// What determines the contact of a step: a proxy that has not arrived, the smooth surface above facets that the
  /// proxy does not touch, one smooth patch, or facets.
  enum class Held { in_motion, above_facets, smooth_patch, crease };

  void initialise(const scene::Mesh& mesh, const Vec3& g, double radius) noexcept;
  void carry() noexcept;
  void set_centre(const Vec3& centre) noexcept;
  bool follow_free_tool(const Vec3& g, double radius) noexcept;
  [[nodiscard]] bool passed_through(const Vec3& g, double radius, double release) const noexcept;
  [[nodiscard]] double lookout(double radius) const noexcept;
  [[nodiscard]] double safe_step(double radius) const noexcept;
  bool relax(const Vec3& g, double radius, double tolerance) noexcept;
  void set_constraint(int i, const scene::BvhHit& hit) noexcept;
  void add_constraint(const scene::BvhHit& hit, double radius) noexcept;
  void keep_active(const Projection& projection) noexcept;
  bool linearise(double radius) noexcept;

  [[nodiscard]] Vec3 normal_at(const Vec3& g, double radius) const noexcept;
  [[nodiscard]] ProxyContact contact_in_motion(const Vec3& g) const noexcept;
  [[nodiscard]] ProxyContact contact_above_facets(const Vec3& g, double radius) const noexcept;
  [[nodiscard]] ProxyContact contact_on_smooth_patch(const Vec3& g, double radius) const noexcept;
  [[nodiscard]] ProxyContact contact_at_crease(const Vec3& g, double radius) const noexcept;
  [[nodiscard]] ProxyContact limit_to_free_space(const ProxyContact& touch, const Vec3& g,
                                                 double radius) const noexcept;
  [[nodiscard]] bool is_smooth(const Constraint& h) const noexcept;
  [[nodiscard]] HalfSpace smooth_half_space(int i, double radius) const noexcept;
  [[nodiscard]] HalfSpace smooth_half_space_at(int i, const Vec3& c, double radius) const noexcept;

  const scene::Mesh* mesh_ = nullptr;
  std::uint64_t mesh_id_ = 0;
  std::vector<Vec3>* path_ = nullptr;
  Vec3 centre_ = Vec3::Zero();
  Vec3 tool_ = Vec3::Zero();  // position of the tool in the previous tick
  bool touching_ = false;
  bool started_inside_ = false;
  Held held_ = Held::in_motion;  // in the last step
  Vec3 carried_ = Vec3::Zero();
  double travelled_ = 0.0;        // Mesh::Impl::travelled in the previous tick
  Vec3 clear_at_ = Vec3::Zero();  // there is no triangle within clear_ [m] of this point
  double clear_ = 0.0;
  int queries_left_ = 0;      // nearest-point queries left in this tick
  std::int32_t seed_ = -1;    // nearest triangle of the last query, start of the next
  scene::BvhHit near_;        // triangle nearest to the centre in this tick, if any
  int constraint_count_ = 0;  // number of constraints
  std::array<Constraint, kMaxHalfSpaces> constraint_;
  std::array<HalfSpace, kMaxHalfSpaces> half_space_;
  Projection active_;
};

}  // namespace palpate::contact
