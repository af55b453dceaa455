#include "palpate/contact/penalty.hpp"

#include <cmath>

#include "palpate/scene/deformable.hpp"
#include "palpate/types/index.hpp"

namespace palpate::contact {
namespace {

constexpr double kExactShare =
    0.5;  // factor on a distance that a free tool may move without a query; grids are not exact
constexpr double kOnSurface = 1e-6;  // [r] at a smaller distance x - q is mostly rounding: the surface normal is used

}  // namespace

const ContactSet& Penalty::step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept {
  set_.size = 0;
  if (!p_WT.allFinite() || !v_WT.allFinite()) return set_;
  near_.step(scene, p_WT, [&](int i) noexcept { return touch(scene.objects[to_index(i)], i, p_WT, t); });
  return set_;
}

/// Adds the contact with an object, if there is one. Returns the distance that the tool may move before the object has
/// to be examined again [m].
double Penalty::touch(const scene::Object& object, int index, const Vec3& p_WT, double t) noexcept {
  if (set_.size == kMaxContacts) return 0.0;
  const Pose X_WO = object.pose(t);
  const Vec3 p_OT = X_WO.R.transpose() * (p_WT - X_WO.p);
  const scene::Nearest near = object.surface->nearest(p_OT);
  const double near_depth = radius_ - near.distance;
  if (!std::isfinite(near_depth)) return 0.0;
  if (!(near_depth > 0.0)) return -kExactShare * near_depth;
  const Vec3 away = p_OT - near.point;
  const double length = away.norm();
  Vec3 n_O = length > kOnSurface * radius_ ? Vec3(std::copysign(1.0, near.distance) / length * away) : near.normal;
  double depth = near_depth;
  if (const scene::Deformable* const soft = object.surface->deformable(); soft != nullptr) {
    const scene::Response met = soft->respond({near.point, n_O, depth, radius_, sphere_});
    if (!(met.depth > 0.0)) return 0.0;
    depth = met.depth;
    n_O = met.normal;
  }
  const Vec3 n = X_WO.R * n_O;
  set_.contact[to_index(set_.size++)] = {
      .object = index, .p_proxy = p_WT + depth * n, .normal = n, .delta_x = depth * n, .depth = depth};
  return 0.0;
}

}  // namespace palpate::contact
