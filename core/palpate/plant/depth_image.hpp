// The image of a simulated depth camera without its errors: in every pixel, the nearest surface along the pixel's ray.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpate/types/spatial.hpp"

namespace palpate::plant {

/// A pinhole camera with the optical frame C of ROS: z forward, x right, y down. Pixel (0, 0) has its centre at (0, 0).
struct Pinhole {
  int columns = 640;
  int rows = 480;
  double fx = 525.0, fy = 525.0;  ///< focal lengths [pixel]
  double cx = 319.5, cy = 239.5;  ///< principal point [pixel]
  double near = 0.05;             ///< smallest depth that is drawn [m]
};

/// Draws triangles into a buffer of inverse depths. On a plane, 1/z is linear in the pixel's coordinates, so that the
/// depth at a pixel's centre is exact: it equals that of a cast ray. Both sides of a triangle are drawn.
class DepthImage {
 public:
  /// Throws std::invalid_argument if the image is empty or larger than 4096 x 4096, or a length is not positive.
  explicit DepthImage(const Pinhole& lens);
  /// Removes everything that was drawn.
  void clear() noexcept;
  /// Draws a mesh with vertices (n * 3) in its frame O [m] and triangles (m * 3) at the pose X_CO, as object `id`.
  /// Indices of the triangles must be below n.
  void draw(std::span<const double> vertices_O, std::span<const std::int32_t> triangles, const Pose& X_CO,
            std::int16_t id);

  [[nodiscard]] const Pinhole& lens() const noexcept { return lens_; }
  /// Inverse depth 1/z of every pixel, row by row; 0 where nothing was drawn [1/m].
  [[nodiscard]] std::span<const float> inverse_depth() const noexcept { return inverse_depth_; }
  /// Cosine of the angle between ray and normal; 0 where nothing was drawn.
  [[nodiscard]] std::vector<float> cosine() const;
  /// Object drawn in every pixel; -1 where nothing was drawn.
  [[nodiscard]] std::span<const std::int16_t> object() const noexcept { return object_; }

 private:
  struct Corner {
    double u, v, w;  ///< image coordinates [pixel], inverse depth [1/m]
  };
  [[nodiscard]] Corner project(const Vec3& p_C) const noexcept;
  /// Draws a triangle that may reach behind the near plane.
  void clip(const Vec3& a, const Vec3& b, const Vec3& c, std::int16_t id) noexcept;
  void fill(const Corner& a, const Corner& b, const Corner& c, float plane, std::int16_t id) noexcept;

  Pinhole lens_;
  std::vector<float> inverse_depth_;
  std::vector<float> plane_;  ///< distance of the drawn triangle's plane from the camera [m]
  std::vector<std::int16_t> object_;
  std::vector<Vec3> corners_C_;
  std::vector<Corner> corners_;
};

}  // namespace palpate::plant
