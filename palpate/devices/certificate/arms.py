"""The loop of a scene: the leader linearised at a pose, the operator's hand, the mapping, and the follower's servo.

For small motions about a pose q of the leader, with hand and drives included, and the wall's normal n,

    (M + I_r + J^T M_h J) q'' + (F_v + J^T B_h J) q' + J^T K_h J q = J_v^T n u,      y = n^T J_v q,

Along n the follower's tip tracks the goal ``scale * y`` with the same second-order servo as each joint; the servo holds
its goal for one period. The transfer function from y to the depth that compresses the spring is therefore

    U(z) = force_scale * scale * [1 0] (z - Phi_f)^-1 (1 - Phi_f) [1 0]^T,     Phi_f = exp([0 1; -w^2 -2 zeta w] T),

while the damping acts on the leader's own velocity, ``force_scale * scale * y'``. A guidance fixture is evaluated at
the commanded tool pose, not at the follower's actual pose, so its U(z) is the constant ``force_scale * scale``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.devices.certificate.coupled import CoupledLoop
from palpate.devices.certificate.exponential import expm
from palpate.devices.certificate.loop import Complex, Modes, Path, SampledLoop, low_pass, modes
from palpate.scene.contact_method import COLLISIONS

_STEP = 1e-5  # step of the numerical differentiation [rad, rad/s]
_POSITIONING = 3  # number of joints that render a force in the mode `paper`


@dataclass(frozen=True)
class HeldLeader:
    """A leader at one pose, held by a hand."""

    arm: Arm
    q: Array
    """Joint positions (n,) [rad, m]."""
    o: _core.SimulationOptions
    hand: _core.HandOptions
    fixture: bool = False
    """True if a guidance fixture renders the force: the follower's servo is not in its loop."""
    parallel_stiffness: float = 0.0
    """Stiffness of fixtures that act in parallel with the rendered wall, on the tool's side [N/m]."""

    @cached_property
    def _matrices(self) -> tuple[Array, Array, Array, Array]:
        """Inertia, damping, stiffness (n, n) and Jacobian (6, n), hand and rotors included."""
        J = self.arm.jacobian(self.q)
        h, plant = self.hand, self.o.leader
        M_h = np.diag([h.mass] * 3 + [h.inertia] * 3)
        B_h = np.diag([h.damping] * 3 + [h.rotational_damping] * 3)
        K_h = np.diag([h.stiffness] * 3 + [h.rotational_stiffness] * 3)
        viscous = (1.0 - self.o.torque.friction.gain) * plant.viscous
        M = self.arm.mass_matrix(self.q) + np.diag(plant.rotor_inertia) + J.T @ M_h @ J
        D_p, K_p = self._platform()
        return M, np.diag(viscous) + J.T @ B_h @ J + D_p, J.T @ K_h @ J + K_p, J

    def _platform(self) -> tuple[Array, Array]:
        """Damping and stiffness (n, n) that an MTM's joint-4 controller adds, from numerical differentiation."""
        n = self.arm.n
        torque = _core.Torque(self.o.torque, self.arm.tau_max, 1.0 / self.o.rate)

        def platform_torque(q: Array, v: Array) -> Array:
            command, _ = torque.step(self.arm, q, v, np.zeros(6))
            return command.tau_platform.copy()

        still, D, K = np.zeros(n), np.zeros((n, n)), np.zeros((n, n))
        for k, e in enumerate(_STEP * np.eye(n)):
            K[:, k] = -(platform_torque(self.q + e, still) - platform_torque(self.q - e, still)) / (2.0 * _STEP)
            D[:, k] = -(platform_torque(self.q, e) - platform_torque(self.q, -e)) / (2.0 * _STEP)
        return D, K

    def _space(self, axes: int = 3) -> tuple[Array, Array, Array, Array]:
        """State-space matrices A (m, m), b (m, axes), c (axes, m), d (axes, m) from the force on the handle to its
        position and velocity; with six axes, from the wrench to position and rotation vector, and to the twist."""
        M, D, S, J = self._matrices
        n, Minv, Jv = len(M), np.linalg.inv(M), J[:axes]
        A = np.block([[np.zeros((n, n)), np.eye(n)], [-Minv @ S, -Minv @ D]])
        rendered = Jv
        if str(self.o.torque.mode).endswith("paper"):
            forces = (np.arange(axes) < 3)[:, None]
            rendered = np.where(forces & (np.arange(n) < _POSITIONING), Jv, 0.0)
        b = np.vstack([np.zeros((n, axes)), Minv @ rendered.T])
        c, d = np.hstack([Jv, np.zeros((axes, n))]), np.hstack([np.zeros((axes, n)), Jv])
        return _with_lags(A, b, c, d, self.o.leader)

    @cached_property
    def _frictionless(self) -> tuple[Array, Array, Array, Array, Modes]:
        A, b, c, d = self._space()
        return A, b, c, d, modes(A)

    def loop(self, n: Array) -> SampledLoop:
        """The loop for a wall with normal n (3,) in the leader's base frame, without dry friction."""
        A, b, c, d, known = self._frictionless
        return self._closed(A, b @ n, n @ c, n @ d, known)

    def coupled(self, spring: Array, damper: Array) -> CoupledLoop:
        """The loop for a wall that touches several spheres, without dry friction.

        spring, damper: wrench on the tool per pose and per twist of the tool (6, 6), for K = 1 N/m and B = 1 N s/m, in
        the axes of the leader's base.
        """
        o, T = self.o, 1.0 / self.o.rate
        A, b, c, d, known = self._frictionless_wrench
        to_tool = np.array([o.mapping.scale] * 3 + [1.0] * 3)  # the tool turns by the handle's angle
        to_hand = o.mapping.force_scale * o.torque.force_gain / o.mapping.scale * to_tool[:, None] * to_tool
        fixtures = felt(o) * self.parallel_stiffness * np.diag([1.0] * 3 + [0.0] * 3)
        return CoupledLoop(A, b, c, d, T, whole_servo_periods(o), to_hand * spring, to_hand * damper, fixtures,
                           _depth(o, 1.0), _velocity(1.0, o.leader.velocity_window, T),
                           low_pass(T, o.stability.low_pass), known)  # fmt: skip

    @cached_property
    def _frictionless_wrench(self) -> tuple[Array, Array, Array, Array, Modes]:
        A, b, c, d = self._space(6)
        return A, b, c, d, modes(A)

    def _closed(self, A: Array, b: Array, c: Array, d: Array, known: Modes) -> SampledLoop:
        o, T = self.o, 1.0 / self.o.rate
        gain = felt(o)
        velocity = _velocity(gain, o.leader.velocity_window, T)
        smooth = low_pass(T, o.stability.low_pass)
        depth = _direct_path(gain) if self.fixture else _depth(o, gain)
        parallel = gain * self.parallel_stiffness
        return SampledLoop(A, b, c, T, whole_servo_periods(o), depth, velocity, d, smooth, known, parallel)


def felt(o: _core.SimulationOptions) -> float:
    """Stiffness or damping at the hand per stiffness or damping of a surface [-]."""
    return o.mapping.force_scale * o.mapping.scale * o.torque.force_gain


def whole_servo_periods(o: _core.SimulationOptions) -> float:
    """The loop delay in whole periods of the simulated drives, with the full jitter added [s]."""
    dt = 1.0 / (o.rate * np.ceil(o.plant_rate / o.rate - 1e-9))
    return float(dt * np.ceil((o.loop_delay + o.loop_jitter) / dt - 0.5))


def _with_lags(A: Array, b: Array, c: Array, d: Array, o: _core.LeaderOptions) -> tuple[Array, Array, Array, Array]:
    """Add the drives' first-order lag at the input and the velocity's low pass at the output, one state per axis."""
    axes = len(c)
    zero, one = np.zeros((axes, axes)), np.eye(axes)
    if o.drive_lag > 0.0:
        A = np.block([[A, b], [np.zeros((axes, len(A))), -one / o.drive_lag]])
        b = np.vstack([np.zeros_like(b), one / o.drive_lag])
        c, d = np.hstack([c, zero]), np.hstack([d, zero])
    if o.velocity_cutoff > 0.0:
        w = 2.0 * np.pi * o.velocity_cutoff
        A = np.block([[A, np.zeros((len(A), axes))], [w * d, -w * one]])
        b, c, d = np.vstack([b, zero]), np.hstack([c, zero]), np.hstack([np.zeros_like(d), one])
    return A, b, c, d


def _direct_path(gain: float) -> Path:
    """U(z) of a law evaluated at the commanded tool pose: a constant gain."""
    return lambda z: np.full_like(z, gain)


def _depth(o: _core.SimulationOptions, gain: float) -> Path:
    """U(z) of the follower's servo, with the delay of asynchronous contact."""
    T, w, zeta = 1.0 / o.rate, 2.0 * np.pi * o.follower.bandwidth, o.follower.damping_ratio
    late = int(np.ceil(o.rate / o.contact.collision_rate)) if o.method in COLLISIONS else 0
    Phi = expm(np.array([[0.0, 1.0], [-(w**2), -2.0 * zeta * w]]) * T) if w > 0.0 else np.zeros((2, 2))
    goal = (np.eye(2) - Phi)[:, 0]
    trace, det = Phi[0, 0] + Phi[1, 1], float(np.linalg.det(Phi))

    def U(z: Complex) -> Complex:
        # [1 0] adj(z - Phi) goal / det(z - Phi)
        top = (z - Phi[1, 1]) * goal[0] + Phi[0, 1] * goal[1]
        return np.asarray(gain * top / (z * z - trace * z + det) * z ** -float(late), dtype=complex)

    return U


def _velocity(gain: float, window: float, T: float) -> Path:
    """W(z): a difference over a window is the mean velocity in this window, delayed by half its length."""

    if window == 0.0:
        return _direct_path(gain)

    def W(z: Complex) -> Complex:  # z is not 1
        x = np.log(z) * (window / T)
        return np.asarray(gain * -np.expm1(-x) / x)

    return W
