"""Relaxation and creep of a contact against the closed form of the Prony law.

The shear modulus relaxes and the bulk modulus does not. By the correspondence principle (Lee and Radok 1960) the force
of a sphere on a half-space is F = 4 G (3 K + G) / (3 K + 4 G) applied to the elastic force, with the operator G of the
Prony series and the constant K. Each factor is a Prony series or the inverse of one, hence a hereditary integral. The
elastic force is that of the same body without viscosity, so only the viscous law is judged.
"""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.world.tissue import viscosity
from palpate.world.tissue.viscosity import Prony
from palpate_lab.verify.bench.tissue.bodies import POISSON, PRONY, TICK, Lab, placed
from palpate_lab.verify.bench.tissue.rows import Found, at_most

RADIUS, DEPTH = 5e-3, 1.5e-3  # [m]
LAYER = (30e-3, 7.5e-3, 37.5e-3)  # thickness, cell, half width [m]
QUICK, SECONDS = 0.05, 4.0  # duration of the rise, and of the whole press [s]
LIMIT = 3.0  # [%]


def sphere_force(prony: Prony, nu: float, t: Array, elastic: Array) -> Array:
    """Force (n,) of viscous tissue whose relaxed force is ``elastic`` (n,) [N], at times (n,) [s]."""
    whole, part = _factors(prony, nu)
    yielded = viscosity.hereditary_force(_inverse(whole), t, elastic)
    return viscosity.hereditary_force(part, t, viscosity.hereditary_force(prony, t, yielded))


def sphere_creep(prony: Prony, nu: float, t: Array, force: Array) -> Array:
    """Relaxed elastic force (n,) [N] of the depth that viscous tissue reaches under a force (n,) [N]."""
    whole, part = _factors(prony, nu)
    yielded = viscosity.hereditary_force(_inverse(part), t, viscosity.hereditary_force(_inverse(prony), t, force))
    return viscosity.hereditary_force(whole, t, yielded)


def measure(lab: Lab, short: bool = False) -> Found:
    """Largest error of the force at a held depth, and at the depth that creeps under a constant force."""
    terms = PRONY[:2] if short else PRONY
    t = np.arange(0.0, 0.5 if short else SECONDS, TICK)
    rise = np.clip(t / QUICK, 0.0, 1.0)
    viscous, rest = lab.layer(*LAYER, prony=terms), lab.layer(*LAYER)
    grid = np.linspace(0.0, 1.0, 5 if short else 9)[1:] * DEPTH
    root = np.sqrt(np.r_[0.0, grid])
    ratio = np.array([lab.steady(rest, RADIUS, d) for d in grid]) / grid**1.5
    ratio = np.r_[2.0 * ratio[0] - ratio[1], ratio]  # of the force to depth^1.5

    def force_at(depth: Array) -> Array:
        return np.interp(np.sqrt(depth), root, ratio) * depth**1.5

    late = t > 2.0 * QUICK
    held = lab.force(viscous, RADIUS, placed((0.0, 0.0), RADIUS - DEPTH * rise))
    expected = sphere_force(terms, POISSON, t, force_at(DEPTH * rise))
    relaxed = np.abs(held / np.maximum(expected, 1e-12) - 1.0)[late].max()

    goal = force_at(np.array(DEPTH)) * rise
    dense = np.linspace(0.0, DEPTH, 400)
    depth = np.interp(sphere_creep(terms, POISSON, t, goal), force_at(dense), dense)
    constant = lab.force(viscous, RADIUS, placed((0.0, 0.0), RADIUS - depth))
    crept = np.abs(constant[late] / goal[late] - 1.0).max()
    rows = (
        at_most("relaxation at a held depth: error of the force", 100.0 * relaxed, LIMIT),
        at_most("creep under a constant force: error of the force", 100.0 * crept, LIMIT),
    )
    often = slice(None, None, 20)
    curves = {"t": t, "held": held, "expected": expected, "depth": depth, "constant": constant, "goal": goal}
    return Found(rows, {"viscosity": {key: value[often].tolist() for key, value in curves.items()}})


def _factors(prony: Prony, nu: float) -> tuple[Prony, Prony]:
    """Normalised Prony series of 3 K + 4 G and of 3 K + G."""
    bulk = 2.0 * (1.0 + nu) / (1.0 - 2.0 * nu)  # 3 K / G at rest
    return [(4.0 * g / (bulk + 4.0), tau) for g, tau in prony], [(g / (bulk + 1.0), tau) for g, tau in prony]


def _inverse(prony: Prony) -> Prony:
    """Terms of the creep compliance, for ``hereditary_force``."""
    return [(-j, time) for j, time in viscosity.retardation(prony)]
