// Spatial quantities in monogram notation (NOTATION.md). SI units: m, rad, s, N, N m.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "palpate/types/lanes.hpp"

namespace palpate {

using Vec3 = Eigen::Vector3d;              ///< column vector (3,)
using Mat3 = Eigen::Matrix3d;              ///< matrix (3, 3)
using Vec6 = Eigen::Matrix<double, 6, 1>;  ///< column vector (6,): linear over angular part
using Mat6 = Eigen::Matrix<double, 6, 6>;  ///< matrix (6, 6)

/// Maximum number of joints of one arm. The bound keeps joint vectors off the heap.
inline constexpr int kMaxJoints = kLanes;
/// One value per joint (n,).
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxJoints, 1>;
/// Matrix over the joints (n, n), for example the inertia matrix.
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
/// Jacobian at the tip, 6 x n: linear rows over angular rows, expressed in the arm's base frame.
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, kMaxJoints>;

/// X_AB: the pose of frame B in frame A. `X_AB * p_BC` is p_AC, and `X_AB * X_BC` is X_AC.
struct Pose {
  Mat3 R = Mat3::Identity();  ///< rotation R_AB
  Vec3 p = Vec3::Zero();      ///< position p_AB_A [m]

  Pose operator*(const Pose& X_BC) const { return {R * X_BC.R, R * X_BC.p + p}; }
  Vec3 operator*(const Vec3& p_BC) const { return R * p_BC + p; }
  /// X_BA, the pose of A in B.
  Pose inverse() const { return {R.transpose(), -(R.transpose() * p)}; }
};

/// V_AB_C: linear velocity of B's origin and angular velocity of B, both relative to A and expressed in C.
struct Twist {
  Vec3 v = Vec3::Zero();  ///< linear velocity [m/s]
  Vec3 w = Vec3::Zero();  ///< angular velocity [rad/s]
};

/// F_T_C: force and torque (about T's origin) that the environment applies to T, expressed in C.
struct Wrench {
  Vec3 f = Vec3::Zero();  ///< force [N]
  Vec3 t = Vec3::Zero();  ///< torque [N m]

  Wrench operator+(const Wrench& o) const { return {f + o.f, t + o.t}; }
  Wrench operator-(const Wrench& o) const { return {f - o.f, t - o.t}; }
};

}  // namespace palpate
