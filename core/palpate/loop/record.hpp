// Copies the core's types into the fields of a tick.
#pragma once

#include <algorithm>
#include <cstddef>

#include "palpate/types/spatial.hpp"

namespace palpate::loop {

/// Copies joint values. Missing joints are zero; joints beyond n are omitted.
template <std::size_t n>
void copy(const JointVector& from, double (&to)[n]) noexcept {
  std::fill_n(to, n, 0.0);
  std::copy_n(from.data(), std::min<std::size_t>(n, static_cast<std::size_t>(from.size())), to);
}

inline void copy(const Vec3& from, double (&to)[3]) noexcept { std::copy_n(from.data(), 3, to); }

/// Copies a rotation as a quaternion w x y z with w >= 0.
inline void copy(const Mat3& R, double (&to)[4]) noexcept {
  const Eigen::Quaterniond q(R);
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  to[0] = sign * q.w(), to[1] = sign * q.x(), to[2] = sign * q.y(), to[3] = sign * q.z();
}

}  // namespace palpate::loop
