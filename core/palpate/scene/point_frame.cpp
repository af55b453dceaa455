#include "palpate/scene/point_frame.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::scene {
namespace {

constexpr double kAtCamera = 1e-6;  // some cameras send the origin for a missing point [m]

bool is_inside(const Vec3& p, const Ball& ball) noexcept {
  return (p - ball.p).squaredNorm() <= ball.radius * ball.radius;
}

}  // namespace

std::vector<double> usable_points(std::span<const double> points_C, const Pose& X_WC, const Ball& region,
                                  std::span<const Ball> tool, FrameCount& count) {
  std::vector<double> out;
  out.reserve(points_C.size());
  for (std::size_t i = 0; i + 2 < points_C.size(); i += 3) {
    const Vec3 p_C(&points_C[i]);
    if (!p_C.allFinite() || p_C.squaredNorm() < kAtCamera * kAtCamera) {
      ++count.invalid;
      continue;
    }
    const Vec3 p = X_WC * p_C;
    if (!is_inside(p, region)) {
      ++count.outside;
    } else if (std::any_of(tool.begin(), tool.end(), [&](const Ball& ball) { return is_inside(p, ball); })) {
      ++count.tool;
    } else {
      for (int k = 0; k < 3; ++k) out.push_back(p[k]);
      ++count.used;
    }
  }
  return out;
}

}  // namespace palpate::scene
