"""Checks before a run that the law `impedance` with `shape_inertia` does not shake a free handle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.errors import SceneError
from palpate.scene.arms import Arms
from palpate.scene.hand import HandPlan
from palpate.scene.scene import Scene

_SURE = 0.8  # fraction of the limit that is accepted: the hand strays from its path
_PLACES = 24  # of the path at which the inertia is computed


def least_mass(inertia: float, hand: float) -> float:
    """The smallest virtual mass [kg] for which the loop through the load cell is stable in free motion.

    The law adds (Lambda / m - 1) F_hand, and F_hand = m_hand a is known one period late, so that

        a_k+1 (Lambda + m_hand) = - (Lambda / m - 1) m_hand a_k + ...

    which grows from tick to tick with alternating sign once (Lambda / m - 1) m_hand > Lambda + m_hand.

    Args:
        inertia: largest inertia Lambda of the arm at the handle [kg].
        hand: mass of the hand that moves with the handle [kg].
    """
    return inertia * hand / (_SURE * (inertia + hand) + hand)


def check_mass(scene: Scene, arms: Arms, path: HandPlan, o: _core.SimulationOptions) -> None:
    """Refuse a virtual mass below `least_mass` at the start or at a place of the operator's path.

    Raises:
        SceneError: the message names the inertia of the arm, the mass of the hand and the smallest virtual mass.
    """
    if scene.torque.law != "impedance" or not scene.torque.shape_inertia:
        return
    inertia = max(_inertia(arms.leader, q, o) for q in _along(scene, arms, path))
    least = least_mass(inertia, o.hand.mass)
    if scene.torque.virtual_mass >= least:
        return
    raise SceneError(
        f"torque.virtual_mass = {scene.torque.virtual_mass:g} kg with shape_inertia: the free handle would shake",
        where=scene.where("torque", "virtual_mass"),
        why=f"the arm has up to {inertia:.3g} kg at the handle on the operator's path, the hand {o.hand.mass:.3g} kg, "
        "and the load cell answers a period late",
        mend=f"use at least {least:.3g} kg, or law stiffness",
    )


def _inertia(arm: Arm, q: Array, o: _core.SimulationOptions) -> float:
    """Largest inertia of the arm at its handle, in any direction, at the joints q (n,) [kg]."""
    whole = arm.orients and str(o.torque.mode).endswith("full")
    cartesian = _core.cartesian if whole else _core.cartesian_place
    Lambda = np.asarray(cartesian(arm, q, np.zeros(arm.n), o.torque.rotor_inertia)[0])[:3, :3]
    return float(np.linalg.eigvalsh(0.5 * (Lambda + Lambda.T)).max())


def _along(scene: Scene, arms: Arms, path: HandPlan) -> Iterator[Array]:
    """Joints (n,) of the leader at the start and at `_PLACES` places of the operator's path."""
    yield arms.q_leader0
    q, X_LH = arms.q_leader0, arms.leader.fk(arms.q_leader0)
    p_LH, R_LW = X_LH[:3, 3].copy(), arms.X_WL[:3, :3].T
    end = 2.0 * path.period if path.period else path.times[-1]
    for t in np.linspace(path.times[0], end, _PLACES):
        p_W = np.array([np.interp(t, path.times, path.positions_W[:, i]) for i in range(3)])
        X_LH[:3, 3] = p_LH + R_LW @ (p_W - path.positions_W[0]) / scene.mapping.scale
        q, _ = arms.leader.ik_nearest(X_LH, q, restarts=0)
        yield q
