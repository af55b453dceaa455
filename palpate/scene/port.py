"""What the passivity layer may assume of a device: the one place that decides delay, friction, counts, acceleration."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from palpate import _core
from palpate.arm import Arm
from palpate.arm.hands import PRESETS
from palpate.base.arrays import Array
from palpate.scene.stability import StabilitySection

_DEFAULT = _core.StabilityOptions()


@dataclass(frozen=True)
class Port:
    """The device at whose handle the layer keeps its account of energy."""

    delay: float
    """Shortest time from a measurement to the force on the hand that follows from it [s]."""
    doubt: float = 0.0
    """The true delay may be longer by this time [s]."""
    mass: float = 0.2
    """Smallest mass that the handle moves with, along any direction [kg]."""
    quantum: float = 0.0
    """Resolution of the measured position of the handle [m]."""
    friction: _core.CertainFriction = field(default_factory=_core.CertainFriction)
    """Friction of the device that certainly acts on the hand, per joint; none by default."""


def apply(section: StabilitySection, port: Port, s: _core.StabilityOptions) -> None:
    """Set the options of the passivity layer that depend on the device; keys of the scene take precedence.

    Without ``stability.acceleration`` the bound is 5 m/s^2, or, if larger, the acceleration that ``force_cap`` gives to
    the handle in a relaxed hand of 50 g.
    """
    known = section.known_delay
    s.delay = port.delay if known is None else known
    s.delay_doubt = (port.doubt if known is None else 0.0) if section.delay_doubt is None else section.delay_doubt
    s.quantum, s.friction = port.quantum, port.friction
    fastest = s.force_cap / (port.mass + PRESETS["relaxed"].mass)  # [m/s^2]
    s.acceleration = section.acceleration or max(_DEFAULT.acceleration, fastest)


def of_arm(arm: Arm, q: Array, o: _core.SimulationOptions, share: float) -> Port:
    """The port of a modelled arm at the joints q (n,), from the options of its simulation.

    Its delay is the mean one. Its friction is `share` of the model's, less what friction compensation or the control
    law removes.
    """
    A, step = o.leader.coupling, o.leader.encoder_step if o.leader.quantised else 0.0 * o.leader.encoder_step
    kept = max(share - _core.removed_friction(o.torque, 1.0 / o.rate), 0.0)
    friction = _core.CertainFriction()
    friction.coulomb, friction.viscous = kept * o.torque.friction.coulomb, kept * o.torque.friction.viscous
    friction.quantum = np.abs(A) @ step
    J, M = arm.jacobian(q)[:3], arm.mass_matrix(q) + np.diag(o.leader.rotor_inertia)
    mass = 1.0 / float(np.linalg.eigvalsh(J @ np.linalg.solve(M, J.T)).max())
    quantum = float(np.linalg.norm((J @ A) * step, axis=0).max())
    return Port(o.loop_delay + 0.5 * o.loop_jitter + o.leader.drive_lag, 0.0, mass, quantum, friction)
