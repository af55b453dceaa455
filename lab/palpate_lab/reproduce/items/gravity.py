"""Equations 10 to 12: the gravity model, its regressor, and its identification from holding torques."""

from __future__ import annotations

from dataclasses import replace
from html import escape

import numpy as np

from palpate.arm import Arm
from palpate.arm.identify.identifiability import identifiability
from palpate.base.arrays import Array
from palpate_lab.reproduce.checks import Check, outcome
from palpate_lab.reproduce.item import Item, Outcome, Work
from palpate_lab.reproduce.items.dynamics import reference, slopes, states

_TRAINED = 40  # poses at which the arm is held [-]


def eq10(work: Work) -> Outcome:
    """Gravity from potential energy, for both arms."""
    checks = []
    for title, arm in (("MTM", Arm.mtm("right")), ("PSM", Arm.psm())):
        energy, newton = [], []
        for q, v in states(arm, work.seed):
            G = arm.gravity(q)
            energy.append(np.abs(G - slopes(arm.potential_energy, q)).max())
            newton.append(np.abs(G - reference(arm).compute(q, v)[2]).max())
        checks.append(
            Check(f"G = ∂P/∂q, {title}", "differences of the potential energy", np.array(energy), 1e-9, "N m")
        )
        checks.append(Check(f"G, {title}", "Pinocchio's Newton-Euler gravity", np.array(newton), 1e-9, "N m"))
    why = "The gravity torque is the slope of the potential energy, and equals an independent recursion."
    return outcome(checks, "η = −d/dt ∂P/∂q̇ + ∂P/∂q", why)


def eq11(work: Work) -> Outcome:
    """Linearity in the parameters, for the model's own and for random ones."""
    arm, rng = Arm.mtm("right"), np.random.default_rng(work.seed)
    own, random = [], []
    k = np.arange(arm.n)
    for q, _ in states(arm, work.seed):
        Y = arm.gravity_regressor(q)
        own.append(np.abs(Y @ arm.moments - reference(arm).compute(q, np.zeros(arm.n))[2]).max())
        scale = rng.uniform(0.5, 2.0, arm.n)
        Pi = arm.moments.reshape(arm.n, 4) * scale[k, None]
        random.append(np.abs(Y @ Pi.ravel() - arm.with_scaled_masses(scale).gravity(q)).max())
    q = np.array([q for q, _ in states(arm, work.seed, 200)])
    found = identifiability(q, np.ones(arm.n, dtype=bool), arm)
    checks = [
        Check("Υ Π of the model", "Pinocchio's gravity", np.array(own), 1e-10, "N m"),
        Check("Υ Π of other masses", "gravity of an arm with these masses", np.array(random), 1e-10, "N m"),
    ]
    more = {
        "parameters": len(arm.moments), "rank": found.structural_rank, "base_parameters": list(found.base),
        "parameters_without_effect": list(found.never),
    }  # fmt: skip
    why = (
        f"The regressor is linear in Π. Of its {len(arm.moments)} columns only {found.structural_rank} are "
        "independent: "
        "predictions are identifiable, single parameters are not. The base parameters are in the data below."
    )
    result = outcome(checks, "−G ≈ −Υ Π, Υ an n × p matrix", why, more=more)
    lines = "".join(f"<li><code>{escape(one)}</code></li>" for one in found.base)
    return replace(result, table=f"{result.table}<details><summary>base parameters</summary><ul>{lines}</ul></details>")


def eq12(work: Work) -> Outcome:
    """Parameters from holding torques, their predictions at other poses, and both signs of the printed law."""
    arm = Arm.mtm("right")
    trained, unseen = states(arm, work.seed, _TRAINED), states(arm, work.seed + 7, 100)
    T = np.concatenate([reference(arm).compute(q, 0 * q)[2] for q, _ in trained])
    Pi = np.linalg.pinv(np.concatenate([arm.gravity_regressor(q) for q, _ in trained]), rcond=1e-10) @ T
    found = identifiability(np.array([q for q, _ in trained]), np.ones(arm.n, dtype=bool), arm)

    def off(parameters: Array) -> Array:
        return np.array([np.abs(arm.gravity_regressor(q) @ parameters - reference(arm).compute(q, 0 * q)[2]).max()
                         for q, _ in unseen])  # fmt: skip

    check = Check("Υ Π_E at 100 unseen poses", "Pinocchio's gravity", off(Pi), 1e-8, "N m")
    minus = float(off(-Pi).max())
    away = float(np.abs(Pi - arm.moments).max())
    more = {
        "poses": _TRAINED, "rank": found.rank, "condition_number": found.condition,
        "residual_with_the_printed_sign_Nm": minus, "largest_difference_of_a_single_parameter": away,
    }  # fmt: skip
    why = (
        "The sign is the other one: with T̄ the torque that holds the arm still, as the text says, the parameters are "
        f"+Υ† T̄. The printed minus would double the weight (up to {minus:.2g} N m) instead of carrying it. Single "
        f"parameters are not found again (up to {away:.2g} off); only their predictions are."
    )
    return outcome([check], "Π_E = −Υ† T̄", why, verdict="differs", more=more)


_FILES = ("core/palpate/arm/serial.cpp", "palpate/arm/identify/gravity.py")

ITEMS = (
    Item("eq10", "Gravity from energy", "Section 2.4, Eq 10",
         "The gravity term follows from the potential energy of the links.",
         eq10, ("R19",), "P does not depend on velocities, so the first term vanishes: G = ∂P/∂q.", _FILES[:1]),
    Item("eq11", "The regressor", "Section 2.4, Eq 11",
         "The gravity term is a matrix of known functions of the joints times unknown constant parameters.",
         eq11, ("R20",), "For static poses the regressor depends on q alone.", _FILES),
    Item("eq12", "Parameters from holding torques", "Section 2.4, Eq 12",
         "The parameters are estimated by a pseudo inverse from torques that hold the arm still at several poses.",
         eq12, ("R21",), "T̄ is the holding torque, hence Π_E = +Υ† T̄.", _FILES),
)  # fmt: skip
