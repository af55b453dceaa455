"""Forms of a gravity model: which columns, with which prior. One line in `FORMS` each.

* ``paper``: the masses alone, Pi = Y^+ T (Eqs 10-12, least squares of the smallest norm).
* ``gravity+springs``: masses, and a constant and a linear spring per joint; least squares.
* ``dvrk``: ten combinations of moments, a polynomial of fourth order per joint, and its direction, as the dVRK has it.
* ``potential`` (ours): masses, springs, and what cables do as a smooth potential of the joints that a bundle of them
  crosses, its smoothness and size found by marginal likelihood (a Gaussian process of the potential, whose slope is
  measured); dry friction of the motors, by the direction each came from. One potential for all joints of a bundle is
  the physics: what pulls at joint 1 as joint 2 moves pulls at joint 2 as joint 1 moves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from palpate import _core
from palpate.arm import Arm
from palpate.arm import dvrk_gravity as dvrk
from palpate.arm.coupling import coupling, drives
from palpate.arrays import Array

Mask = NDArray[np.bool_]

#: Joints (from 0) that a bundle of cables crosses: along the arm, around the platform, through the gimbal.
BUNDLES: tuple[tuple[int, ...], ...] = ((0, 1, 2), (3,), (4, 5))
_CENTRES = {1: 14, 2: 40, 3: 60}  # of a field, by its number of joints

_MASS, _MOMENT, _SPRING, _COULOMB = 0.3, 0.1, 0.3, 0.05  # prior standard deviations [kg, kg m, N m, N m]


@dataclass(frozen=True)
class Hyper:
    """Size [N m] and length [rad] of each field, and what is left unexplained per joint [N m]."""

    size: tuple[float, ...]
    length: tuple[tuple[float, ...], ...]
    noise: tuple[float, ...]


@dataclass(frozen=True)
class Design:
    """Linear model: tau (k, n) = (columns @ into) x + friction_columns y, with x, y standard normal a priori.

    `into` maps the free parameters to theta; None: no prior, plain least squares.
    """

    terms: _core.GravityTerms
    into: Array  # (m, p)
    coulomb: int  # polynomial coefficients of friction per drive; 0: none
    motor_friction: bool
    prior: bool


def _of_measured(measured: Mask, each: int) -> Array:
    """(each n, p): `each` parameters per joint, of measured joints alone.

    Of a link's moments: static torques of the other joints cannot tell it from the next one; what is told of it stays
    with the last measured joint's, so that the others hold nothing made up.
    """
    return np.asarray(np.eye(each * len(measured))[:, np.repeat(measured, each)])


def paper(arm: Arm, q: Array, measured: Mask, hyper: Hyper | None) -> Design:
    """Masses alone."""
    terms = _core.GravityTerms()
    return Design(terms, _of_measured(measured, 4), 0, True, False)


def gravity_springs(arm: Arm, q: Array, measured: Mask, hyper: Hyper | None) -> Design:
    """Masses, a constant and a linear spring per joint."""
    into = linalg.block_diag(_of_measured(measured, 4), _of_measured(measured, 2))
    return Design(_core.GravityTerms(degree=1), into, 0, True, False)


def dvrk_form(arm: Arm, q: Array, measured: Mask, hyper: Hyper | None) -> Design:
    """Ten parameters of gravity, a polynomial per joint, and a constant of its direction.

    The dVRK fits a whole polynomial per direction, to grids of poses reached both ways. Poses visited in any order are
    reached from below where they are high, so that two polynomials would each be blind for half of the range.
    """
    into = linalg.block_diag(dvrk.moments_of_parameters(arm), _of_measured(measured, 5))
    return Design(_core.GravityTerms(degree=4), into, 1, False, False)


def potential(arm: Arm, q: Array, measured: Mask, hyper: Hyper | None) -> Design:
    """Masses, springs, and a field per bundle of cables; prior as `hyper` says."""
    assert hyper is not None
    fields = []
    scales = np.diag(np.tile([_MASS, _MOMENT, _MOMENT, _MOMENT], arm.n))
    blocks = [scales @ _of_measured(measured, 4), _SPRING * _of_measured(measured, 2)]
    for joints, size, length in zip(BUNDLES, hyper.size, hyper.length, strict=True):
        z, scale = centres(q[:, joints]), np.array(length)
        fields.append(_core.Field(list(joints), z, scale))
        distance = (z[:, None] - z[None]) / scale
        K = np.exp(-0.5 * (distance**2).sum(axis=2)) + 1e-6 * np.eye(len(z))
        block = (
            size * scale.min() * np.linalg.inv(np.linalg.cholesky(K)).T
        )  # weights have the covariance size^2 l^2 / K
        blocks.append(block)
    return Design(_core.GravityTerms(degree=1, fields=fields), linalg.block_diag(*blocks), 1, True, True)


FORMS: dict[str, Callable[[Arm, Array, Mask, Hyper | None], Design]] = {
    "potential": potential,
    "dvrk": dvrk_form,
    "gravity+springs": gravity_springs,
    "paper": paper,
}
DEFAULT = "potential"


def centres(x: Array) -> Array:
    """Where a field of the joints x (k, d) has its centres (c, d)."""
    return _spread(np.ascontiguousarray(x).tobytes(), x.shape[1])


@lru_cache(maxsize=8)  # the search for the fields' shape asks again and again
def _spread(values: bytes, joints: int) -> Array:
    """Spread over the poses, farthest next; evenly for a single joint."""
    x = np.frombuffer(values).reshape(-1, joints)
    if joints == 1:
        margin = 0.1 * (x.max() - x.min()) + 1e-3
        return np.linspace(x.min() - margin, x.max() + margin, _CENTRES[1])[:, None]
    x = np.unique(x, axis=0)
    spread = (x - x.mean(axis=0)) / (x.std(axis=0) + 1e-9)
    chosen = [int(np.argmin((spread**2).sum(axis=1)))]
    distance = ((spread - spread[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(_CENTRES[x.shape[1]], len(x)):
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, ((spread - spread[chosen[-1]]) ** 2).sum(axis=1))
    return np.asarray(x[chosen])


def columns(design: Design, q: Array, direction: Array, arm: Arm) -> Array:
    """(k, n, p + n * coulomb): what tau is linear in, at poses q (k, n) reached in `direction` (k, n)."""
    Phi = arm.gravity_columns(design.terms, q) @ design.into
    if design.coulomb == 0:
        return np.asarray(Phi)
    x = drives(q, arm) if design.motor_friction else q
    to_joints = np.linalg.inv(coupling(arm)).T if design.motor_friction else np.eye(arm.n)
    powers = np.stack([x**k for k in range(design.coulomb)], axis=2) * direction[:, :, None]  # (k, drive, power)
    friction = to_joints[None, :, :, None] * powers[:, None]  # (k, joint, drive, power)
    scale = _COULOMB if design.prior else 1.0
    return np.concatenate([Phi, scale * friction.reshape(len(q), arm.n, -1)], axis=2)


def friction_of(design: Design, x: Array, n: int) -> Array:
    """(n, coulomb) of the solution x of `columns`."""
    if design.coulomb == 0:
        return np.zeros((n, 1))
    scale = _COULOMB if design.prior else 1.0
    return np.asarray(scale * x[design.into.shape[1] :].reshape(n, design.coulomb))
