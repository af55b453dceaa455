// Kinematics and dynamics of a serial chain in one pass, on plain arrays that hold one number per joint ("lanes"), so
// that the work of all links is done side by side. World axes throughout; spatial quantities refer to the point at the
// base's origin. recursion.cpp chooses between the portable and the AVX2 build of the same code; both use the same
// operations in the same order and return the same bits.
#pragma once

namespace palpate::arm {

inline constexpr int kLanes = 8;
using Lanes = double[kLanes];

/// The chain's constants. Lanes beyond `n` are zero.
struct alignas(64) ChainLanes {
  Lanes m{}, c[3]{};  ///< mass [kg]; centre of mass in the link's axes [m]
  Lanes I[6]{};       ///< inertia about it in the link's axes: xx, xy, yy, xz, yz, zz [kg m^2]
  struct Joint {
    double R[3][3];  ///< columns of the joint's axes in the previous link, at q = 0
    double p[3];     ///< [m]
    double axis[3];  ///< in the joint's own axes
    int aligned;     ///< 0, 1, 2: the axis is the joint's x, y or z; -1: it is none of them
    bool prismatic;
  } joint[kLanes];
  double g[3]{};  ///< acceleration of gravity [m/s^2]
  int n = 0;
};

/// What one pass computes.
struct alignas(64) ChainState {
  // by kinematics()
  Lanes R[9]{}, p[3]{};   ///< pose of each link: columns of R one after the other, origin [m]
  Lanes Jv[3]{}, Jw[3]{};  ///< Jacobian: velocity of the point at the base's origin, angular velocity
  // by dynamics()
  double M[kLanes][kLanes]{};  ///< inertia matrix; the lower triangle, M[k][i] with i <= k, is valid
  Lanes tau{}, G{};            ///< inverse dynamics M a + C v + G; gravity alone
  Lanes V[6]{}, A[6]{};        ///< velocity and acceleration (less gravity) of each link, linear over angular
};

/// Poses and Jacobian at q.
void kinematics(const ChainLanes& c, const double* q, ChainState& s) noexcept;
/// Everything at (q, v, a), n numbers each.
void dynamics(const ChainLanes& c, const double* q, const double* v, const double* a, ChainState& s) noexcept;

namespace portable {
void chain_kinematics(const ChainLanes& c, const double* q, ChainState& s) noexcept;
void chain_dynamics(const ChainLanes& c, const double* q, const double* v, const double* a, ChainState& s) noexcept;
}  // namespace portable
namespace avx2 {
void chain_kinematics(const ChainLanes& c, const double* q, ChainState& s) noexcept;
void chain_dynamics(const ChainLanes& c, const double* q, const double* v, const double* a, ChainState& s) noexcept;
}  // namespace avx2

}  // namespace palpate::arm
