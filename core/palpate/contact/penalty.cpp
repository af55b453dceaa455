#include "palpate/contact/penalty.hpp"

#include <cmath>

#include "palpate/scene/deformable.hpp"

namespace palpate::contact {
namespace {

constexpr double kOnSurface = 1e-6;  // [r] at a smaller distance x - q is mostly rounding: the surface normal is used

}  // namespace

const ContactSet& Penalty::step(const scene::Snapshot& scene, const Vec3& p_WT, const Vec3& v_WT, double t) noexcept {
  set_.size = 0;
  if (!p_WT.allFinite() || !v_WT.allFinite()) return set_;
  for (std::size_t i = 0; i < scene.objects.size() && set_.size < kMaxContacts; ++i) {
    const scene::Object& object = scene.objects[i];
    const Pose X_WO = object.pose(t);
    const Vec3 p_OT = X_WO.R.transpose() * (p_WT - X_WO.p);
    const scene::Nearest near = object.surface->nearest(p_OT);
    const double near_depth = radius_ - near.distance;
    if (!(near_depth > 0.0) || !std::isfinite(near_depth)) continue;
    const Vec3 away = p_OT - near.point;
    const double length = away.norm();
    Vec3 n_O = length > kOnSurface * radius_ ? Vec3(std::copysign(1.0, near.distance) / length * away) : near.normal;
    double depth = near_depth;
    if (const scene::Deformable* const soft = object.surface->deformable(); soft != nullptr) {
      const scene::Response met = soft->respond({near.point, n_O, depth, radius_, sphere_});
      if (!(met.depth > 0.0)) continue;
      depth = met.depth;
      n_O = met.normal;
    }
    const Vec3 n = X_WO.R * n_O;
    set_.contact[static_cast<std::size_t>(set_.size++)] = {
        .object = static_cast<int>(i), .p_proxy = p_WT + depth * n, .normal = n, .delta_x = depth * n, .depth = depth};
  }
  return set_;
}

}  // namespace palpate::contact
