#include "palpate/scene/primitives.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace palpate::scene {
namespace {

double positive(double value, const char* what) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(std::string(what) + " must be a positive length in metres, got " +
                                std::to_string(value));
  return value;
}

/// Nearest point of a tube: the points within `radius` of a curve. axis: point of the curve nearest to p; away: unit
/// normal for a point p on the curve.
Nearest around(const Vec3& p, const Vec3& axis, double radius, const Vec3& away) {
  const Vec3 out = p - axis;
  const double length = out.norm();
  const Vec3 n = length > 0.0 ? Vec3(out / length) : away;
  return {length - radius, axis + radius * n, n};
}

}  // namespace

Nearest Plane::nearest(const Vec3& p) const noexcept { return {p.z(), {p.x(), p.y(), 0.0}, Vec3::UnitZ()}; }

Sphere::Sphere(double radius) : radius_(positive(radius, "radius of a sphere")) {}

Nearest Sphere::nearest(const Vec3& p) const noexcept { return around(p, Vec3::Zero(), radius_, Vec3::UnitZ()); }

Box::Box(const Vec3& size) : half_(size / 2.0) {
  for (int i = 0; i < 3; ++i) positive(size[i], "side of a box");
}

Nearest Box::nearest(const Vec3& p) const noexcept {
  const Vec3 beyond = p.cwiseAbs() - half_;
  int axis = 0;
  const double most = beyond.maxCoeff(&axis);
  Nearest found;
  if (most <= 0.0) {  // inside: the nearest point is on the nearest face
    found.distance = most;
    found.normal[axis] = std::copysign(1.0, p[axis]);
    found.point = p;
    found.point[axis] = std::copysign(half_[axis], p[axis]);
    return found;
  }
  found.point = p.cwiseMax(-half_).cwiseMin(half_);
  const Vec3 out = p - found.point;
  found.distance = out.norm();
  found.normal = out / found.distance;
  return found;
}

Cylinder::Cylinder(double radius, double length)
    : radius_(positive(radius, "radius of a cylinder")), half_(positive(length, "length of a cylinder") / 2.0) {}

Nearest Cylinder::nearest(const Vec3& p) const noexcept {
  const double ring = std::hypot(p.x(), p.y());
  const Vec3 radial = ring > 0.0 ? Vec3(p.x() / ring, p.y() / ring, 0.0) : Vec3::UnitX();
  const Vec3 axial(0.0, 0.0, std::copysign(1.0, p.z()));
  const double beyond_side = ring - radius_, beyond_end = std::abs(p.z()) - half_;
  if (beyond_side <= 0.0 && beyond_end <= 0.0) {
    if (beyond_side >= beyond_end) return {beyond_side, p - beyond_side * radial, radial};
    return {beyond_end, p - beyond_end * axial, axial};
  }
  const Vec3 out = std::max(beyond_side, 0.0) * radial + std::max(beyond_end, 0.0) * axial;
  const double distance = out.norm();
  return {distance, p - out, out / distance};
}

Capsule::Capsule(double radius, double length)
    : radius_(positive(radius, "radius of a capsule")), half_(positive(length, "length of a capsule") / 2.0) {}

Nearest Capsule::nearest(const Vec3& p) const noexcept {
  return around(p, {0.0, 0.0, std::clamp(p.z(), -half_, half_)}, radius_, Vec3::UnitX());
}

}  // namespace palpate::scene
