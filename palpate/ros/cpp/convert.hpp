// Converts structs of the core to messages and back. Values are not checked here; the code that uses them checks them.
#pragma once

#include <builtin_interfaces/msg/time.hpp>
#include <cmath>
#include <cstdint>
#include <geometry_msgs/msg/pose.hpp>
#include <geometry_msgs/msg/quaternion.hpp>
#include <geometry_msgs/msg/twist.hpp>
#include <geometry_msgs/msg/vector3.hpp>
#include <geometry_msgs/msg/wrench.hpp>
#include <limits>

#include "palpate/types/spatial.hpp"

namespace palpate::ros {

[[nodiscard]] inline builtin_interfaces::msg::Time stamp(std::int64_t ns) noexcept {
  builtin_interfaces::msg::Time time;
  time.sec = static_cast<std::int32_t>(ns / 1'000'000'000);
  time.nanosec = static_cast<std::uint32_t>(ns % 1'000'000'000);
  return time;
}
/// Time of a stamp [ns since 1970]; 0 marks invalid data.
[[nodiscard]] inline std::int64_t nanoseconds(const builtin_interfaces::msg::Time& time) noexcept {
  return std::int64_t{time.sec} * 1'000'000'000 + time.nanosec;
}

template <class Xyz>
[[nodiscard]] Vec3 vector_of(const Xyz& m) noexcept {
  return {m.x, m.y, m.z};
}
template <class Xyz>
void put(const Vec3& x, Xyz& m) noexcept {
  m.x = x.x();
  m.y = x.y();
  m.z = x.z();
}

/// Rotation matrix of a quaternion of any norm; NaN for a quaternion of zero or non-finite norm.
[[nodiscard]] inline Mat3 rotation_of(const geometry_msgs::msg::Quaternion& m) noexcept {
  const double norm = std::sqrt(m.w * m.w + m.x * m.x + m.y * m.y + m.z * m.z);
  if (!std::isfinite(norm) || norm < 1e-6) return Mat3::Constant(std::numeric_limits<double>::quiet_NaN());
  return Eigen::Quaterniond(m.w / norm, m.x / norm, m.y / norm, m.z / norm).toRotationMatrix();
}
inline void put(const Mat3& R, geometry_msgs::msg::Quaternion& m) noexcept {
  const Eigen::Quaterniond q(R);
  m.w = q.w();
  m.x = q.x();
  m.y = q.y();
  m.z = q.z();
}

[[nodiscard]] inline Pose pose_of(const geometry_msgs::msg::Pose& m) noexcept {
  return {rotation_of(m.orientation), vector_of(m.position)};
}
inline void put(const Pose& X, geometry_msgs::msg::Pose& m) noexcept {
  put(X.p, m.position);
  put(X.R, m.orientation);
}

[[nodiscard]] inline Twist twist_of(const geometry_msgs::msg::Twist& m) noexcept {
  return {vector_of(m.linear), vector_of(m.angular)};
}
inline void put(const Twist& V, geometry_msgs::msg::Twist& m) noexcept {
  put(V.v, m.linear);
  put(V.w, m.angular);
}

[[nodiscard]] inline Wrench wrench_of(const geometry_msgs::msg::Wrench& m) noexcept {
  return {vector_of(m.force), vector_of(m.torque)};
}
inline void put(const Wrench& F, geometry_msgs::msg::Wrench& m) noexcept {
  put(F.f, m.force);
  put(F.t, m.torque);
}

}  // namespace palpate::ros
