#include "palpate/scene/extent.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::scene {
namespace {

template <class... Numbers>
[[noreturn]] void refuse(const char* format, Numbers... numbers) {
  char text[300];
  std::snprintf(text, sizeof text, format, numbers...);
  throw std::invalid_argument(text);
}

/// Median size of the triangles' bounding boxes [m], from a sample of at most ten thousand triangles.
double typical_size(std::span<const double> vertices, std::span<const std::int32_t> triangles) {
  const std::size_t count = triangles.size() / 3, stride = count / 10'000 + 1;
  std::vector<double> sizes;
  for (std::size_t t = 0; t < count; t += stride) {
    const auto corner = [&](std::size_t c) {
      return Vec3(&vertices[3 * static_cast<std::size_t>(triangles[3 * t + c])]);
    };
    const Vec3 a = corner(0), b = corner(1), c = corner(2);
    sizes.push_back((a.cwiseMax(b).cwiseMax(c) - a.cwiseMin(b).cwiseMin(c)).maxCoeff());
  }
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

}  // namespace

void require_extent(std::span<const double> vertices, std::span<const std::int32_t> triangles) {
  Vec3 low = Vec3(vertices.data()), high = low;
  std::size_t farthest = 0;
  double far = 0.0;
  for (std::size_t i = 0; i < vertices.size(); i += 3) {
    const Vec3 p(&vertices[i]);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    if (p.cwiseAbs().maxCoeff() > far) {
      far = p.cwiseAbs().maxCoeff();
      farthest = i;
    }
  }
  const double extent = (high - low).maxCoeff(), size = typical_size(vertices, triangles);
  const double *stray = &vertices[farthest], x = stray[0], y = stray[1], z = stray[2];
  if (!(far <= kMaxCoordinate))
    refuse("mesh: a vertex at (%.3g, %.3g, %.3g) m is more than %.3g m away; check the unit, or remove it", x, y, z,
           kMaxCoordinate);
  if (!(extent >= kMinExtent))
    refuse("mesh: its largest extent is %.3g m, less than %.3g m; check the unit", extent, kMinExtent);
  if (size < kMinSizeToExtent * extent)
    refuse(
        "mesh: it is %.3g m large, and half of its triangles are smaller than %.3g m: too fine for one index; "
        "remove the stray vertex at (%.3g, %.3g, %.3g) m",
        extent, size, x, y, z);
  if (size < kMinSizeToDistance * far)
    refuse(
        "mesh: it lies %.3g m from its origin, where numbers are too coarse for triangles of %.3g m; move it to its "
        "origin and place it by its pose",
        far, size);
}

}  // namespace palpate::scene
