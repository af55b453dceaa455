// Surfaces in closed form: plane, sphere, box, cylinder, capsule. Exact distances, nothing to build.
#pragma once

#include "palpate/scene/surface.hpp"

namespace palpate::scene {

/// The half-space z <= 0 of its frame; out is +z.
class Plane final : public Surface {
 public:
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
};

/// Around the origin.
class Sphere final : public Surface {
 public:
  /// Throws std::invalid_argument unless radius is a positive length [m].
  explicit Sphere(double radius);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  [[nodiscard]] double radius() const noexcept { return radius_; }

 private:
  double radius_;
};

/// Around the origin, its sides along the axes. A point on the medial axis belongs to the first axis that is nearest.
class Box final : public Surface {
 public:
  /// Throws std::invalid_argument unless all three sides are positive lengths [m].
  explicit Box(const Vec3& size);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  [[nodiscard]] Vec3 size() const noexcept { return 2.0 * half_; }

 private:
  Vec3 half_;
};

/// Around the z axis, its middle at the origin, with flat ends.
class Cylinder final : public Surface {
 public:
  /// Throws std::invalid_argument unless radius and length are positive [m].
  Cylinder(double radius, double length);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  [[nodiscard]] double radius() const noexcept { return radius_; }
  [[nodiscard]] double length() const noexcept { return 2.0 * half_; }

 private:
  double radius_, half_;
};

/// Around the z axis, its middle at the origin: all points within `radius` of a segment of `length`.
class Capsule final : public Surface {
 public:
  /// Throws std::invalid_argument unless radius and length are positive [m].
  Capsule(double radius, double length);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  [[nodiscard]] double radius() const noexcept { return radius_; }
  [[nodiscard]] double length() const noexcept { return 2.0 * half_; }

 private:
  double radius_, half_;
};

}  // namespace palpate::scene
