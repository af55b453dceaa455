#include "palpate/clouds/point_frame.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::clouds {
namespace {

constexpr double kAtCamera = 1e-6;  // some cameras send the origin for a missing point [m]

bool is_inside(const Vec3& p, const Ball& ball) noexcept {
  return (p - ball.p).squaredNorm() <= ball.radius * ball.radius;
}

/// Most points lie outside the region: they are recognised in C, before they are transformed.
template <typename Number>
std::vector<double> usable(std::span<const Number> points_C, const Pose& X_WC, const Ball& region,
                           std::span<const Ball> tool, FrameCount& count) {
  std::vector<double> out;
  const Vec3 centre_C = X_WC.R.transpose() * (region.p - X_WC.p);
  const double radius2 = region.radius * region.radius;
  for (std::size_t i = 0; i + 2 < points_C.size(); i += 3) {
    const Vec3 p_C(points_C[i], points_C[i + 1], points_C[i + 2]);
    const bool near = (p_C - centre_C).squaredNorm() <= radius2;  // false for points that are not finite
    if (!near || p_C.squaredNorm() < kAtCamera * kAtCamera) {
      const bool valid = std::isfinite(p_C.sum()) && p_C.squaredNorm() >= kAtCamera * kAtCamera;
      ++(valid ? count.outside : count.invalid);
      continue;
    }
    const Vec3 p = X_WC * p_C;
    if (std::any_of(tool.begin(), tool.end(), [&](const Ball& ball) { return is_inside(p, ball); })) {
      ++count.tool;
      continue;
    }
    for (int k = 0; k < 3; ++k) out.push_back(p[k]);
    ++count.used;
  }
  return out;
}

}  // namespace

std::vector<double> usable_points(std::span<const float> points_C, const Pose& X_WC, const Ball& region,
                                  std::span<const Ball> tool, FrameCount& count) {
  return usable(points_C, X_WC, region, tool, count);
}

std::vector<double> usable_points(std::span<const double> points_C, const Pose& X_WC, const Ball& region,
                                  std::span<const Ball> tool, FrameCount& count) {
  return usable(points_C, X_WC, region, tool, count);
}

}  // namespace palpate::clouds
