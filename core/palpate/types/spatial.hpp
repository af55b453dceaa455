// Spatial quantities in monogram notation (NOTATION.md). SI units: m, rad, s, N, N m.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "palpate/types/lanes.hpp"

namespace palpate {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Joints a single arm may have: a bound, so that joint vectors never touch the heap.
inline constexpr int kMaxJoints = kLanes;
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxJoints, kMaxJoints>;
/// The storage of a joint vector, which has room for kMaxJoints numbers whatever its size. Those beyond its size may be
/// anything, unless their owner keeps them at zero.
[[nodiscard]] inline Lanes& lanes(JointVector& x) noexcept { return *reinterpret_cast<Lanes*>(x.data()); }
[[nodiscard]] inline const Lanes& lanes(const JointVector& x) noexcept {
  return *reinterpret_cast<const Lanes*>(x.data());
}
/// Copies a joint vector and fills the lanes beyond its size with zeros.
inline void pad(const JointVector& x, Lanes& out) noexcept {
  for (Eigen::Index k = 0; k < kMaxJoints; ++k) out[k] = k < x.size() ? x.data()[k] : 0.0;
}
/// 6 x n, linear rows over angular rows, at the tip, expressed in the arm's base.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

/// X_AB: the pose of frame B in frame A; `X_AB * p_BC` = p_AC, `X_AB * X_BC` = X_AC.
struct Pose {
  Mat3 R = Mat3::Identity();  ///< R_AB
  Vec3 p = Vec3::Zero();      ///< p_AB_A [m]

  Pose operator*(const Pose& X_BC) const { return {R * X_BC.R, R * X_BC.p + p}; }
  Vec3 operator*(const Vec3& p_BC) const { return R * p_BC + p; }
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// V_AB_C: velocity of B's origin and angular velocity of B relative to A, expressed in C.
struct Twist {
  Vec3 v = Vec3::Zero();  ///< [m/s]
  Vec3 w = Vec3::Zero();  ///< [rad/s]
};

/// F_T_C: force and torque (about T's origin) that the environment applies to T, expressed in C.
struct Wrench {
  Vec3 f = Vec3::Zero();  ///< [N]
  Vec3 t = Vec3::Zero();  ///< [N m]

  Wrench operator+(const Wrench& o) const { return {f + o.f, t + o.t}; }
  Wrench operator-(const Wrench& o) const { return {f - o.f, t - o.t}; }
};

}  // namespace palpate
