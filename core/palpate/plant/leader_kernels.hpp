// The arithmetic of one step of the simulated leader, over all lanes at once (leader.cpp states the equations).
#pragma once

#include "palpate/arm/lane_dynamics.hpp"

namespace palpate::plant {

/// A spatial quantity of the handle as lanes: linear, 0, angular, 0.
using HandleLanes = Lanes;

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

/// Constants of the hand.
struct alignas(64) HandLanes {
  HandleLanes M, K, B;  ///< inertia, stiffness and damping
};

/// What the hand does in one step: its force is F - response V, with the velocity V of the handle at the end.
struct alignas(64) HandForce {
  HandleLanes F, response;
};

/// Middle of the step, and the velocity extrapolated to it.
void to_middle(double dt, const Lanes& q, const Lanes& v, const Lanes& v_before, Lanes& q_mid, Lanes& v_mid) noexcept;

/// Sums the loads on the joints and computes the velocity V of the handle at v.
void sum_loads(const arm::LaneDynamics& d, const LeaderJoints& joints, double dt, const Lanes& tau_drives,
               const Lanes& tau_elastic, const Lanes& q_mid, const Lanes& v, LeaderLoads& loads,
               HandleLanes& V) noexcept;

/// Force of spring and damper for the error of the handle's pose and the velocity (v, w) of the path.
void pull(const HandLanes& hand, const HandleLanes& error, const double (&v)[3], const double (&w)[3],
          HandleLanes& F) noexcept;

/// The same towards the pose (p, columns of R). Error: displacement and rotation vector from the handle to that pose.
/// Half the sum of the cross products of both poses' axes is the axis of the rotation times its sine. Returns false if
/// the rotation is too large for the series of the arc sine; the rotation vector and its moment are then invalid.
[[nodiscard]] bool pull_towards(const arm::LaneDynamics& d, const HandLanes& hand, const double (&p)[3],
                                const double (&R)[9], const double (&v)[3], const double (&w)[3], HandleLanes& error,
                                HandleLanes& F) noexcept;

/// Equation A v = b of the velocity at the end of the step: the inertia, and the momentum after all impulses but dry
/// friction. d.M includes the inertia of the hand and of its response; V: velocity of the handle at v; F_push:
/// additional force on the handle.
void assemble(const arm::LaneDynamics& d, const LeaderJoints& joints, const HandLanes& hand, double dt,
              const HandForce& force, const HandleLanes& F_push, const HandleLanes& V, const LeaderLoads& loads,
              const Lanes& v, Lanes (&A)[kLanes], Lanes& b) noexcept;

/// Force of the hand after the joints have changed from v to v_next, and that of the arm on the hand: by Newton's law
/// for the hand's mass, its mass times its acceleration minus the person's force. Returns the square of the hand's
/// linear force [N^2].
double react(const arm::LaneDynamics& d, const HandLanes& hand, double dt, const HandForce& force,
             const HandleLanes& F_push, const HandleLanes& V, const Lanes& v, const Lanes& v_next, HandleLanes& F,
             HandleLanes& arm_on_hand) noexcept;

/// End of the step, within the limits: v becomes v_before, and v_next becomes v.
void to_end(double dt, const LeaderJoints& joints, const Lanes& q_mid, const Lanes& v_next, Lanes& v, Lanes& v_before,
            Lanes& q) noexcept;

}  // namespace palpate::plant
