// The proxy of one surface that answers `nearest` (primitives, grids, implicit surfaces): a sphere that stays outside.
//
// phi(x) is the signed distance, n(x) its normal. The proxy's centre c lives where phi(c) >= r; each tick it comes as
// near to the tool x as it can without crossing the surface. Two things can happen:
//
//   1. x is within the memory's meaning: its own nearest place is on the side that c is on. Then c = x + (r - phi) n
//   and
//      F = k (r - phi) n exactly. Proof of the side: both ends of the way from c to there are r away from the surface,
//      and the way is shorter than 2 r, so that it crosses nothing.
//   2. Otherwise (a second wall, the far half of a plate, the other face of a box) c goes by safe steps to the point
//      nearest to x in the half-spaces of the walls that it met: one is a face, two a concave edge, three a corner.
//
// A step is never longer than half of what is free: nothing is jumped over, however fast the tool is, as long as phi
// grows at most twice as fast as a distance.
#pragma once

#include <array>
#include <cstdint>

#include "palpate/contact/half_spaces.hpp"
#include "palpate/contact/object_proxy.hpp"
#include "palpate/scene/surface.hpp"

namespace palpate::contact {

/// In the object's frame O.
class FieldProxy {
 public:
  using Touch = ObjectProxy::Touch;

  void reset() noexcept { surface_id_ = 0; }
  /// Moves the proxy after the tool at g; a surface that the tool has gone through lets go at `release`.
  Touch step(const scene::Surface& surface, const Vec3& g, double radius, double release) noexcept;
  [[nodiscard]] bool started_inside() const noexcept { return started_inside_; }

 private:
  /// A wall that the proxy met: its place nearest to the proxy and the normal there.
  struct Wall {
    Vec3 q = Vec3::Zero(), n = Vec3::Zero();
  };

  void place(const Vec3& g) noexcept;
  [[nodiscard]] bool free_at(const Vec3& g) noexcept;
  [[nodiscard]] bool settles_above(const Vec3& g) noexcept;
  bool relax(const Vec3& g) noexcept;
  void go_to(const Vec3& centre) noexcept;
  void meet(const scene::Nearest& near) noexcept;
  void follow_walls() noexcept;
  void keep_active() noexcept;
  [[nodiscard]] Touch held(const Vec3& g) const noexcept;

  const scene::Surface* surface_ = nullptr;  // of this tick
  std::uint64_t surface_id_ = 0;             // of the last one
  double radius_ = 0.0;
  Vec3 centre_ = Vec3::Zero();
  scene::Nearest near_;  // to the centre
  scene::Nearest tool_;  // to the tool, of this tick
  bool touching_ = false;
  bool started_inside_ = false;
  int walls_ = 0;
  std::array<Wall, kMaxHalfSpaces> wall_;
  std::array<HalfSpace, kMaxHalfSpaces> half_space_;
  Projection active_;
};

}  // namespace palpate::contact
