"""A leader on a bench: its plant, a control law and a hand, without scene and follower."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import palpate
from palpate import _core

SUBSTEPS = 10


@dataclass
class Bench:
    """One arm held by a hand; `tick` runs one millisecond."""

    arm: palpate.Arm
    leader: _core.Leader
    torque: _core.Torque
    model: _core.Arm
    status: int = 0

    def tick(self, F, X=None, V=None):
        """Render F (6,) [N, N m] for a hand at the pose X with the twist V; returns the command."""
        leader = self.leader
        command, self.status = self.torque.step(
            self.model, leader.q_measured, leader.v_measured, F, F_cell_L=leader.F_cell_L
        )
        leader.obey(command)
        X = self.arm.fk(self.arm.home) if X is None else X
        leader.step(1e-4, X, np.zeros(6) if V is None else V, n=SUBSTEPS)
        return command


def bench(
    law="stiffness", *, name="mtm_right", friction=False, hand=True, scale=1.0, quantised=False, noise=0.0, **changes
):
    arm = palpate.Arm.model(name)
    options = arm.leader_options()
    torque = _core.TorqueOptions()
    torque.law, torque.rotor_inertia = law, options.rotor_inertia
    torque.friction.coulomb, torque.friction.viscous = options.coulomb, options.viscous
    torque.platform_gain = 0.5 if arm.has_platform else 0.0
    for key, value in changes.items():
        target, *rest = key.split("__")
        setattr(torque if not rest else getattr(torque, target), rest[0] if rest else target, value)
    if not friction:
        options.coulomb, options.viscous = np.zeros(arm.n), np.zeros(arm.n)
    options.quantised, options.cell_noise = quantised, noise
    grip = _core.HandOptions()
    if not hand:
        grip.mass = grip.damping = grip.stiffness = grip.inertia = 0.0
        grip.rotational_damping = grip.rotational_stiffness = 0.0
    leader = _core.Leader(arm, options, grip)
    leader.reset(arm.home)
    model = arm.with_scaled_masses(np.full(arm.n, scale))
    return Bench(arm, leader, _core.Torque(torque, arm.tau_max), model)
