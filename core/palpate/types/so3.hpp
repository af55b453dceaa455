// Rotation vectors: the axis of a rotation times its angle. Not inline, since every inlined copy of Eigen's conversions
// takes a third of a second to compile.
#pragma once

#include "palpate/types/spatial.hpp"

namespace palpate {

/// Rotation vector of R, with an angle between 0 and pi [rad]: the logarithm of SO(3).
[[nodiscard]] Vec3 rotation_vector(const Mat3& R) noexcept;
/// Derivative J of the rotation vector phi with respect to a small rotation before it: log(exp(d) exp(phi)) = phi + J
/// d.
[[nodiscard]] Mat3 rotation_vector_derivative(const Vec3& phi) noexcept;
/// Angle and axis of R, with an angle between 0 and pi [rad].
[[nodiscard]] Eigen::AngleAxisd angle_axis(const Mat3& R) noexcept;
/// Rotation by the rotation vector theta [rad]: the exponential of SO(3).
[[nodiscard]] Mat3 rotation_by(const Vec3& theta) noexcept;
/// The smallest rotation that turns the direction of a into the direction of b; half a turn when they are opposite.
[[nodiscard]] Mat3 rotation_between(const Vec3& a, const Vec3& b) noexcept;

}  // namespace palpate
