// Primitive surfaces in closed form, with exact distances: plane, sphere, box, cylinder, capsule.
#pragma once

#include "palpate/scene/surface.hpp"

namespace palpate::scene {

/// The half-space z <= 0 of its frame O, with the outward normal +z.
class Plane final : public Surface {
 public:
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
};

/// Sphere around the origin of O.
class Sphere final : public Surface {
 public:
  /// Throws std::invalid_argument unless radius is a positive length [m].
  explicit Sphere(double radius);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  [[nodiscard]] double radius() const noexcept { return radius_; }  ///< radius [m]

 private:
  double radius_;
};

/// Box around the origin of O, with its sides along the axes. If several faces are equally near to a point inside, the
/// first of their axes decides.
class Box final : public Surface {
 public:
  /// Throws std::invalid_argument unless all three sides are positive lengths [m].
  explicit Box(const Vec3& size);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  /// Lengths of the sides [m].
  [[nodiscard]] Vec3 size() const noexcept { return 2.0 * half_; }

 private:
  Vec3 half_;
};

/// Cylinder around the z axis of O, centred at the origin, with flat ends.
class Cylinder final : public Surface {
 public:
  /// Throws std::invalid_argument unless radius and length are positive [m].
  Cylinder(double radius, double length);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  [[nodiscard]] double radius() const noexcept { return radius_; }      ///< radius [m]
  [[nodiscard]] double length() const noexcept { return 2.0 * half_; }  ///< length along z [m]

 private:
  double radius_, half_;
};

/// Capsule around the z axis of O, centred at the origin: all points within `radius` of a segment of `length`.
class Capsule final : public Surface {
 public:
  /// Throws std::invalid_argument unless radius and length are positive [m].
  Capsule(double radius, double length);
  [[nodiscard]] Nearest nearest(const Vec3& p) const noexcept override;
  [[nodiscard]] double radius() const noexcept { return radius_; }      ///< radius [m]
  [[nodiscard]] double length() const noexcept { return 2.0 * half_; }  ///< length along z, without the caps [m]

 private:
  double radius_, half_;
};

}  // namespace palpate::scene
