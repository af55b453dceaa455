#include "palpate/scene/cloud.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "palpate/scene/extent.hpp"

namespace palpate::scene {

Cloud::Cloud(std::span<const double> points, double radius) : points_(points.begin(), points.end()), radius_(radius) {
  if (points.empty() || points.size() % 3 != 0)
    throw std::invalid_argument("a cloud needs points (n, 3), at least one");
  if (!(radius > 0.0) || !std::isfinite(radius))
    throw std::invalid_argument("radius of a cloud's points must be a positive length in metres, got " +
                                std::to_string(radius));
  for (const double x : points)
    if (!(std::abs(x) <= kMaxCoordinate)) throw std::invalid_argument("points of a cloud must be finite, within 1e9 m");
  std::vector<std::int32_t> corners(points.size());
  for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::int32_t>(i / 3);
  bvh_ = build_bvh(points_, corners);
}

Nearest Cloud::nearest(const Vec3& p) const noexcept {
  const BvhHit hit = bvh_closest(bvh_, p.data(), {std::numeric_limits<double>::infinity(), 0.0, 0.0, -1});
  const Vec3 centre(&points_[3 * static_cast<std::size_t>(hit.triangle < 0 ? 0 : hit.triangle)]);
  const Vec3 out = p - centre;
  const double away = out.norm();
  const Vec3 n = away > 0.0 ? Vec3(out / away) : Vec3::UnitZ();
  return {away - radius_, centre + radius_ * n, n};
}

}  // namespace palpate::scene
