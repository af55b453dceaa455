#include "palpate/contact/algorithm1.hpp"

#include <algorithm>

namespace palpate::contact::algorithm1 {
namespace {

constexpr double kVanished = 1e-9;  // of a sum of unit vectors: beyond doubt rounding

}  // namespace

Plane average(const CollisionPoints& points, const Vec3& n_last, const Vec3& p_WT) noexcept {
  const auto first = points.point.begin(), last = first + points.size;
  Vec3 sum = Vec3::Zero();
  for (auto i = first; i != last; ++i) {
    sum += i->n;
  }
  const double length = sum.norm();
  const auto deepest = std::max_element(first, last, [](const auto& a, const auto& b) { return a.depth < b.depth; });
  return {length > kVanished ? Vec3(sum / length) : n_last, p_WT + deepest->depth * deepest->n};
}

Deflection deflect(const Plane& plane, const Vec3& p_WT, const Vec3& v_WT) noexcept {
  const Vec3& n = plane.n;
  const Vec3 delta_x_total = plane.p_proxy - p_WT;
  return {delta_x_total, v_WT, n.dot(delta_x_total) * n, n.dot(v_WT) * n};
}

}  // namespace palpate::contact::algorithm1
