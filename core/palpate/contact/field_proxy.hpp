// The proxy of one surface that provides Surface::nearest() (primitives, grids, implicit surfaces): a sphere that stays
// outside the surface while the tool goes in.
//
// phi(x) is the signed distance and n(x) its normal. The centre c of the proxy stays where phi(c) >= r. In each tick c
// moves as near to the tool g as possible without crossing the surface. There are two cases:
//
//   1. The surface point nearest to g is on the side of c. Then c = g + (r - phi) n and F = k (r - phi) n exactly. Both
//      ends of the path from c to the new centre are r away from the surface and the path is shorter than 2 r, which
//      proves that it does not cross the surface.
//   2. Otherwise (a second wall, the far half of a plate, another face of a box) c moves in safe steps to the point
//      nearest to g in the half-spaces of the walls found so far. One wall is a face, two form a concave edge and three
//      a corner.
//
// A step is at most half of the clearance. The proxy therefore crosses nothing, however fast the tool is, as long as
// |grad phi| <= 2.
#pragma once

#include <array>
#include <cstdint>

#include "palpate/contact/half_spaces.hpp"
#include "palpate/contact/object_proxy.hpp"
#include "palpate/scene/surface.hpp"

namespace palpate::contact {

/// Proxy of one surface. All vectors are expressed in the object's frame O.
class FieldProxy {
 public:
  using ProxyContact = ObjectProxy::ProxyContact;

  /// Discards the state: the next step() places the proxy anew.
  void reset() noexcept { surface_id_ = 0; }
  /// Moves the proxy towards the tool at g [m] and returns the contact. radius: radius of the sphere [m]. release:
  /// deflection that releases a tool that has passed through the object [m].
  ProxyContact step(const scene::Surface& surface, const Vec3& g, double radius, double release) noexcept;
  /// Distance that a free tool, which is at g [m], may move before step() does more than follow it [m]; 0 unless free.
  [[nodiscard]] double free_way(const Vec3& g) const noexcept;
  /// Lets the proxy follow a free tool to g [m] without a step, within free_way().
  void follow(const scene::Surface& surface, const Vec3& g) noexcept;
  /// Derivative of the normal of the last step's contact with the tool's position g [1/m].
  [[nodiscard]] Mat3 normal_gradient(const Vec3& normal, const Vec3& g) const noexcept;
  /// True if the proxy started with the tool inside the object, until the tool is free.
  [[nodiscard]] bool started_inside() const noexcept { return started_inside_; }

 private:
  /// A wall near the proxy: the surface point q nearest to the proxy [m] and the unit normal n at q.
  struct Wall {
    Vec3 q = Vec3::Zero(), n = Vec3::Zero();
  };

  void initialise(const Vec3& g) noexcept;
  [[nodiscard]] bool follow_free_tool(const Vec3& g) noexcept;
  [[nodiscard]] bool project_tool(const Vec3& g) noexcept;
  bool relax(const Vec3& g) noexcept;
  void set_centre(const Vec3& centre) noexcept;
  void add_wall(const scene::Nearest& near) noexcept;
  void follow_walls() noexcept;
  void keep_active() noexcept;
  [[nodiscard]] ProxyContact contact_from_deflection(const Vec3& g) const noexcept;

  const scene::Surface* surface_ = nullptr;  // surface of this tick
  std::uint64_t surface_id_ = 0;             // id of the surface of the previous tick
  double radius_ = 0.0;                      // radius of the sphere [m]
  Vec3 centre_ = Vec3::Zero();               // centre of the proxy [m]
  scene::Nearest near_;                      // surface point nearest to the centre
  scene::Nearest tool_;                      // surface point nearest to the tool in this tick
  bool touching_ = false;
  bool projected_ = false;  // project_tool() found the contact of the last step
  bool started_inside_ = false;
  int walls_ = 0;  // number of walls
  std::array<Wall, kMaxHalfSpaces> wall_;
  std::array<HalfSpace, kMaxHalfSpaces> half_space_;
  Projection active_;
};

}  // namespace palpate::contact
