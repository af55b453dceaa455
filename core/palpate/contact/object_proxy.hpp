// The proxy of one mesh: a sphere that stays outside while the tool goes in.
//
// The proxy's centre c lives where the SPR fits: at least its radius r from every triangle. Each tick it comes as
// near to the tool x as it can without ever crossing the surface,
//
//   c = argmin |c - x|   subject to   n_i . (c - q_i) >= r,      delta_x = c - x,
//
// with q_i the point of triangle i nearest to the proxy and n_i = (c - q_i) / |c - q_i|: half-spaces that keep clear
// of their triangle wherever c goes in them (a triangle is convex). Which side is out is a memory of where the proxy
// is, not a guess from the surface's winding, so the force is right at any depth, behind thin plates, past the medial
// axis. Faces, convex edges (rounded by r), concave edges and corners are one, two and three active half-spaces.
//
// Where the mesh is smooth, the facet is replaced by the surface that it stands for (scene/smooth.hpp): the normal
// that passes through the tool and the distance along it. Truth: F = k (r - phi) n, phi the signed distance.
//
// Release: the side one came from is kept beyond the far side as well, so that a thin plate holds. It is given up when
// the tool is provably through: the object is closed, the tool's sphere is outside and clear of it, and the
// deflection is more than `release`, a force that nobody renders.
//
// A tool that starts inside a closed object (or one that appears around it) is put outside at the nearest point;
// started_inside() says so until the tool is free. Open surfaces are touched from either side.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "palpate/contact/half_spaces.hpp"
#include "palpate/scene/mesh_impl.hpp"

namespace palpate::contact {

/// The proxy of one object, in the object's frame O.
class ObjectProxy {
 public:
  struct Touch {
    bool touching = false;
    Vec3 delta = Vec3::Zero();   ///< p_proxy - p_tool, without friction
    Vec3 normal = Vec3::Zero();  ///< unit, out
    double depth = 0.0;          ///< delta . normal
  };

  void reset() noexcept { mesh_ = nullptr; }
  /// Moves the proxy after the tool at g; a closed object that the tool has gone through lets go at `release`.
  Touch step(const scene::Mesh& mesh, const Vec3& g, double radius, double release) noexcept;
  /// For judges: every place that the centre passes through is appended to `path` (Method::watch).
  void watch(std::vector<Vec3>* path) noexcept { path_ = path; }
  [[nodiscard]] bool started_inside() const noexcept { return started_inside_; }

 private:
  /// A triangle that holds the proxy, with its half-space at the proxy's present place.
  struct Hold {
    scene::SurfacePoint at;
    Vec3 q = Vec3::Zero();
  };

  void place(const scene::Mesh& mesh, const Vec3& g, double radius) noexcept;
  void go(const Vec3& centre) noexcept;
  bool fly(const Vec3& g, double radius) noexcept;
  [[nodiscard]] bool gone_through(const Vec3& g, double radius, double release) const noexcept;
  [[nodiscard]] double safe_step(double radius) const noexcept;
  bool relax(const Vec3& g, double radius, double tolerance) noexcept;
  void hold(int i, const scene::BvhHit& hit) noexcept;
  void add(const scene::BvhHit& hit, double radius) noexcept;
  void keep_active(const Projection& projection) noexcept;
  bool linearise(double radius) noexcept;

  [[nodiscard]] Touch on_the_way(const Vec3& g) const noexcept;
  [[nodiscard]] Touch graze(const Vec3& g, double radius) const noexcept;
  [[nodiscard]] Touch touch_smooth(const Vec3& g, double radius) const noexcept;
  [[nodiscard]] Touch touch_hard(const Vec3& g, double radius) const noexcept;
  [[nodiscard]] Touch outside(const Touch& touch, const Vec3& g, double radius) const noexcept;
  [[nodiscard]] bool is_smooth(const Hold& h) const noexcept;
  [[nodiscard]] HalfSpace shaded(int i, double radius) const noexcept;

  const scene::Mesh* mesh_ = nullptr;
  std::uint64_t mesh_id_ = 0;
  std::vector<Vec3>* path_ = nullptr;
  Vec3 centre_ = Vec3::Zero();
  Vec3 tool_ = Vec3::Zero();  // where the tool was
  bool touching_ = false;
  bool started_inside_ = false;
  Vec3 clear_at_ = Vec3::Zero();  // no triangle within clear_ of this point
  double clear_ = 0.0;
  int queries_left_ = 0;    // in this tick
  std::int32_t seed_ = -1;  // triangle of the last query
  scene::BvhHit near_;      // nearest triangle to the centre in this tick, if any
  int holds_ = 0;
  std::array<Hold, kMaxHalfSpaces> hold_;
  std::array<HalfSpace, kMaxHalfSpaces> half_space_;
  Projection active_;
};

}  // namespace palpate::contact
