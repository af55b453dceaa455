#include "palpate/scene/bvh_disc.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate::scene {
namespace {

constexpr double kShort = 1.0 - 0x1p-22;  // factor on the normal, so that its length is at most 1 after rounding

/// Mean normal of the triangles, weighted by area. Zero when the normals cancel or the triangles have no area.
std::array<float, 3> mean_normal(std::span<const Corner> corners) noexcept {
  Corner sum{};
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    const Corner &a = corners[i], &b = corners[i + 1], &c = corners[i + 2];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t l = (k + 1) % 3, m = (k + 2) % 3;
      sum[k] += (b[l] - a[l]) * (c[m] - a[m]) - (b[m] - a[m]) * (c[l] - a[l]);
    }
  }
  const double length = std::hypot(sum[0], sum[1], sum[2]);
  std::array<float, 3> normal{};
  if (!(length > 0.0)) return normal;
  for (std::size_t k = 0; k < 3; ++k) normal[k] = static_cast<float>(kShort * sum[k] / length);
  return normal;
}

/// Centre of the corners' bounding box.
std::array<float, 3> middle(std::span<const Corner> corners) noexcept {
  std::array<float, 3> out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto [low, high] = std::minmax_element(corners.begin(), corners.end(),
                                                 [k](const Corner& x, const Corner& y) { return x[k] < y[k]; });
    out[k] = static_cast<float>(0.5 * ((*low)[k] + (*high)[k]));
  }
  return out;
}

}  // namespace

Disc disc_around(std::span<const Corner> corners) noexcept {
  Disc disc{middle(corners), mean_normal(corners), 0.0F, 0.0F};
  const auto each = [&](auto&& act) {
    for (const Corner& x : corners) {
      double far2 = 0.0, height = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double v = x[k] - static_cast<double>(disc.centre[k]);
        far2 += v * v;
        height += v * static_cast<double>(disc.normal[k]);
      }
      act(far2, height);
    }
  };
  double low = 0.0, high = 0.0;  // moves the centre to the middle between the lowest and the highest corner
  each([&](double, double height) { low = std::min(low, height), high = std::max(high, height); });
  for (std::size_t k = 0; k < 3; ++k) disc.centre[k] += static_cast<float>(0.5 * (low + high)) * disc.normal[k];
  double radius2 = 0.0, half = 0.0;
  each([&](double far2, double height) {
    radius2 = std::max(radius2, far2 - height * height);
    half = std::max(half, std::abs(height));
  });
  disc.radius = static_cast<float>(std::sqrt(radius2));
  disc.half = static_cast<float>(half);
  return disc;
}

}  // namespace palpate::scene
