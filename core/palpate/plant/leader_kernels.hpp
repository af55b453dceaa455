// The arithmetic of one step of the simulated leader, over all lanes at once (leader.cpp states the equations).
#pragma once

#include "palpate/arm/lane_dynamics.hpp"

namespace palpate::plant {

using Six = double[6];  ///< linear over angular

/// Constants of the joints, zero beyond the last joint.
struct alignas(64) LeaderJoints {
  Lanes coulomb, viscous, rotor;  ///< as LeaderOptions
  Lanes q_min, q_max;             ///< [rad]
};

/// What acts on the joints, besides the hand.
struct alignas(64) LeaderLoads {
  Lanes tau;     ///< torques of drives, weight, motion and spring [N m]
  Lanes lo, hi;  ///< bounds of the friction impulse; infinite towards an end stop [N m s]
};

/// Middle of the step, and the velocity extrapolated to it.
void to_middle(double dt, const Lanes& q, const Lanes& v, const Lanes& v_before, Lanes& q_mid, Lanes& v_mid) noexcept;

/// Sums the loads on the joints and computes the velocity V of the handle at v.
void sum_loads(const arm::LaneDynamics& d, const LeaderJoints& joints, double dt, const Lanes& tau_drives,
               const Lanes& tau_elastic, const Lanes& q_mid, const Lanes& v, LeaderLoads& loads, Six& V) noexcept;

/// Equation A v = b of the velocity at the end of the step: inertia of arm and hand, and their momentum after all
/// impulses but friction. H: inertia of the hand and of its answer to v; push: impulse on the handle; tau: sum of the
/// joint torques.
void assemble(const arm::LaneDynamics& d, const LeaderJoints& joints, double dt, const Six& H, const Six& push,
              const Lanes& tau, const Lanes& v, Lanes (&A)[kLanes], Lanes& b) noexcept;

/// Change of the handle's velocity when the joints change from v to v_next.
void change_of_velocity(const arm::LaneDynamics& d, const Lanes& v, const Lanes& v_next, Six& dV) noexcept;

/// End of the step, within the limits: v becomes v_before, and v_next becomes v.
void to_end(double dt, const LeaderJoints& joints, const Lanes& q_mid, const Lanes& v_next, Lanes& v, Lanes& v_before,
            Lanes& q) noexcept;

}  // namespace palpate::plant
