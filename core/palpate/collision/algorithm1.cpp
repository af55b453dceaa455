#include "palpate/collision/algorithm1.hpp"

#include <algorithm>

namespace palpate::collision::algorithm1 {
namespace {

constexpr double kVanished = 1e-9;  // a shorter sum of unit vectors consists of rounding errors

}  // namespace

const CollisionPoint& deepest(const CollisionPoints& points) noexcept {
  const auto first = points.point.begin(), last = first + points.size;
  return *std::max_element(first, last, [](const auto& a, const auto& b) { return a.depth < b.depth; });
}

Vec3 average_normal(const CollisionPoints& points, const Vec3& n_last) noexcept {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < points.size; ++i) {
    sum += points.point[static_cast<std::size_t>(i)].n;
  }
  const double length = sum.norm();
  return length > kVanished ? Vec3(sum / length) : n_last;
}

GrownPlane average(const CollisionPoints& points, const Vec3& n_last, const Vec3& p) noexcept {
  const CollisionPoint& j = deepest(points);
  return {average_normal(points, n_last), p + j.depth * j.n};
}

GrownPlane through_deepest(const CollisionPoints& points, const Vec3& n, const Vec3& p, double radius) noexcept {
  return {n, p + (radius - n.dot(p - deepest(points).p)) * n};
}

Deflection deflect(const GrownPlane& plane, const Vec3& p, const Vec3& v) noexcept {
  const Vec3& n = plane.n;
  const Vec3 delta_x_total = plane.p_proxy - p;
  return {delta_x_total, v, n.dot(delta_x_total) * n, n.dot(v) * n};
}

}  // namespace palpate::collision::algorithm1
