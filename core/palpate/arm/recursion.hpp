// Kinematics and dynamics of a serial chain in one pass. All numbers of one kind stand side by side, one "lane" per
// joint, so that the work of all links is done with vector instructions. World axes throughout; spatial quantities
// refer to the point at the base's origin. recursion_portable.cpp chooses between the builds for every machine,
// AVX2 and AVX-512 of the same code. All execute the same operations in the same order and return the same bits
// (tests/arm holds this).
#pragma once

#include <cstddef>
#include <cstdint>

#include "palpate/arm/lane_dynamics.hpp"
#include "palpate/types/lanes.hpp"

namespace palpate::arm {

using LaneMask = std::int64_t[kLanes];  ///< all bits set, or none

/// Constants of the chain. The axes of each link are turned here so that z is the axis of its joint. Lanes beyond `n`
/// are zero.
struct alignas(64) ChainLanes {
  Lanes m{}, c[3]{};     ///< mass [kg]; centre of mass in the link's axes [m]
  Lanes m_carried{};     ///< mass of the link and of all links after it [kg]
  Lanes I[6]{};          ///< inertia about the centre of mass in the link's axes: xx, xy, yy, xz, yz, zz [kg m^2]
  Lanes R[9]{}, p[3]{};  ///< pose in the previous link at q = 0: columns of R one after the other, origin [m]
  Lanes turns{},
      slides{};  ///< 1 for a revolute joint, which turns about z; 1 for a prismatic one, which slides along z
  LaneMask revolute{}, prismatic{}, joints{};  ///< the same as masks; joints: of either kind
  double g[3]{};                               ///< acceleration of gravity [m/s^2]
  double tip[4][3]{};                          ///< pose of the tip in the last link: three columns of R, origin [m]
  int n = 0;                                   ///< number of joints
};

/// Results of one pass. LaneDynamics::bias is the inverse dynamics M a + C v + G of the given a.
struct alignas(64) ChainState : LaneDynamics {
  // by kinematics(), and so are J and tip
  Lanes R[9]{}, p[3]{};    ///< pose of each link: columns of R one after the other, origin [m]
  Lanes Jv[3]{}, Jw[3]{};  ///< Jacobian: velocity of the point at the base's origin, angular velocity
  // by dynamics()
  Lanes G{};             ///< gravity alone
  Lanes V[6]{}, A[6]{};  ///< velocity and acceleration (minus gravity) of each link, linear over angular
};

/// Poses and Jacobian at q. Numbers beyond n are ignored.
void kinematics(const ChainLanes& c, const Lanes& q, ChainState& s) noexcept;
/// Poses, Jacobian and dynamics at (q, v, a), with a body at the tip. Numbers beyond n are ignored.
void dynamics(const ChainLanes& c, const Lanes& q, const Lanes& v, const Lanes& a, const TipBody& body,
              ChainState& s) noexcept;

namespace portable {
void chain_kinematics(const ChainLanes& c, const Lanes& q, ChainState& s) noexcept;
void chain_dynamics(const ChainLanes& c, const Lanes& q, const Lanes& v, const Lanes& a, const TipBody& body,
                    ChainState& s) noexcept;
}  // namespace portable
namespace avx2 {
void chain_kinematics(const ChainLanes& c, const Lanes& q, ChainState& s) noexcept;
void chain_dynamics(const ChainLanes& c, const Lanes& q, const Lanes& v, const Lanes& a, const TipBody& body,
                    ChainState& s) noexcept;
}  // namespace avx2
namespace avx512 {
void chain_kinematics(const ChainLanes& c, const Lanes& q, ChainState& s) noexcept;
void chain_dynamics(const ChainLanes& c, const Lanes& q, const Lanes& v, const Lanes& a, const TipBody& body,
                    ChainState& s) noexcept;
}  // namespace avx512

}  // namespace palpate::arm
