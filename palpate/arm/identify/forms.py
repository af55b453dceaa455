"""Forms of a gravity model: the columns of the regressor and their prior. Each form has an entry in `FORMS`.

* ``paper``: masses only, Pi = Y^+ T (Eqs 10-12, least squares of the smallest norm).
* ``gravity+springs``: masses, and a constant and a linear spring per joint; least squares.
* ``dvrk``: ten combinations of moments, a polynomial of fourth order per joint, and friction by approach direction,
  as in the dVRK.
* ``potential`` (this project's form): masses, springs, a cable potential and dry friction of the motors. The torque of
  each bundle of cables is the gradient of a smooth potential of the joints that the bundle crosses. The potential is a
  Gaussian process; its size and length scales maximise the marginal likelihood. One potential per bundle makes the
  stiffness symmetric: d tau_1 / d q_2 = d tau_2 / d q_1.
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
from palpate.base.arrays import Array

Mask = NDArray[np.bool_]

#: Joints (from 0) that each bundle of cables crosses: along the arm, around the platform, through the gimbal.
BUNDLES: tuple[tuple[int, ...], ...] = ((0, 1, 2), (3,), (4, 5))
_CENTRES = {1: 14, 2: 40, 3: 60}  # number of centres of a field, by its number of joints

_MASS, _MOMENT, _SPRING, _COULOMB = 0.3, 0.1, 0.3, 0.05  # prior standard deviations [kg, kg m, N m, N m]


@dataclass(frozen=True)
class Hyper:
    """Size [N m] and length scales [rad] of each field; standard deviation of the residual per joint [N m]."""

    size: tuple[float, ...]
    length: tuple[tuple[float, ...], ...]
    noise: tuple[float, ...]


@dataclass(frozen=True)
class Design:
    """Linear model tau (k, n) = (columns @ into) x + friction_columns y; the prior of x and y is standard normal.

    `into` maps the free parameters x to theta. Without `prior`, the fit is plain least squares.
    """

    terms: _core.GravityTerms
    blocks: tuple[Array, ...]  # of the block diagonal matrix `into`
    coulomb: int  # polynomial coefficients of friction per drive; 0: none
    motor_friction: bool
    prior: bool

    @property
    def into(self) -> Array:
        """Matrix (m, p) of the blocks."""
        return np.asarray(linalg.block_diag(*self.blocks))

    @property
    def p(self) -> int:
        """Number of free parameters x."""
        return sum(block.shape[1] for block in self.blocks)


def _of_measured(measured: Mask, each: int) -> Array:
    """Selection matrix (each n, p): `each` parameters per joint, for measured joints only.

    Static torques of the measured joints cannot separate the moments of an unmeasured link from those of the previous
    link. They are attributed to the last measured link, and the parameters of unmeasured links stay zero.
    """
    return np.asarray(np.eye(each * len(measured))[:, np.repeat(measured, each)])


def paper(arm: Arm, q: Array, measured: Mask, hyper: Hyper | None) -> Design:
    """Masses only."""
    terms = _core.GravityTerms()
    return Design(terms, (_of_measured(measured, 4),), 0, True, False)


def gravity_springs(arm: Arm, q: Array, measured: Mask, hyper: Hyper | None) -> Design:
    """Masses, a constant and a linear spring per joint."""
    blocks = _of_measured(measured, 4), _of_measured(measured, 2)
    return Design(_core.GravityTerms(degree=1), blocks, 0, True, False)


def dvrk_form(arm: Arm, q: Array, measured: Mask, hyper: Hyper | None) -> Design:
    """Ten gravity parameters, a polynomial per joint, and constant friction by approach direction.

    The dVRK fits one polynomial per direction, to grids of poses that are reached from both sides. Poses visited in
    random order are mostly reached from below near the upper limit, so each polynomial would lack half of the range.
    """
    blocks = dvrk.moments_of_parameters(arm), _of_measured(measured, 5)
    return Design(_core.GravityTerms(degree=4), blocks, 1, False, False)


def potential(arm: Arm, q: Array, measured: Mask, hyper: Hyper | None) -> Design:
    """Masses, springs, and a field per bundle of cables; `hyper` gives the prior of the fields."""
    assert hyper is not None
    fields: list[_core.Field] = []
    scales = np.diag(np.tile([_MASS, _MOMENT, _MOMENT, _MOMENT], arm.n))
    blocks = [scales @ _of_measured(measured, 4), _SPRING * _of_measured(measured, 2)]
    for joints, size, length in zip(BUNDLES, hyper.size, hyper.length, strict=True):
        field, block = _field(q, joints, length)
        fields.append(field)
        blocks.append(size * block)
    return Design(_core.GravityTerms(degree=1, fields=fields), tuple(blocks), 1, True, True)


def _field(q: Array, joints: tuple[int, ...], length: tuple[float, ...]) -> tuple[_core.Field, Array]:
    """The field of a bundle of cables, and its block of `into` for a field of the size 1 N m."""
    z, scale = centres(q[:, joints]), np.array(length)
    distance = (z[:, None] - z[None]) / scale
    K = np.exp(-0.5 * (distance**2).sum(axis=2)) + 1e-6 * np.eye(len(z))
    # The weights have the covariance size^2 l^2 K^-1.
    return _core.Field(list(joints), z, scale), scale.min() * np.linalg.inv(np.linalg.cholesky(K)).T


def field_columns(arm: Arm, q: Array, bundle: int, length: tuple[float, ...]) -> Array:
    """Columns (k, n, c) of the field of one bundle of cables, of the size 1 N m."""
    field, block = _field(q, BUNDLES[bundle], length)
    every = arm.gravity_columns(_core.GravityTerms(fields=[field]), q)
    return np.asarray(every[:, :, -len(block) :].reshape(-1, len(block)) @ block).reshape(*q.shape, -1)


FORMS: dict[str, Callable[[Arm, Array, Mask, Hyper | None], Design]] = {
    "potential": potential,
    "dvrk": dvrk_form,
    "gravity+springs": gravity_springs,
    "paper": paper,
}
DEFAULT = "potential"


def centres(x: Array) -> Array:
    """Centres (c, d) of a field over the joints x (k, d) [rad]."""
    return _spread(np.ascontiguousarray(x).tobytes(), x.shape[1])


@lru_cache(maxsize=8)  # the tuning of the hyperparameters calls it often
def _spread(values: bytes, joints: int) -> Array:
    """Evenly spaced centres for one joint, else farthest-point sampling of the poses."""
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
    """Regressor (k, n, p + n * coulomb) of tau at poses q (k, n) approached in `direction` (k, n)."""
    every, starts = arm.gravity_columns(design.terms, q), np.cumsum([0, *(len(block) for block in design.blocks)])
    parts = [every[:, :, i : i + len(block)] @ block for i, block in zip(starts, design.blocks, strict=False)]
    Phi = np.concatenate(parts, axis=2)
    if design.coulomb == 0:
        return np.asarray(Phi)
    x = drives(q, arm) if design.motor_friction else q
    to_joints = np.linalg.inv(coupling(arm)).T if design.motor_friction else np.eye(arm.n)
    powers = np.stack([x**k for k in range(design.coulomb)], axis=2) * direction[:, :, None]  # (k, drive, power)
    friction = to_joints[None, :, :, None] * powers[:, None]  # (k, joint, drive, power)
    scale = _COULOMB if design.prior else 1.0
    return np.concatenate([Phi, scale * friction.reshape(len(q), arm.n, -1)], axis=2)


def friction_of(design: Design, x: Array, n: int) -> Array:
    """Friction coefficients (n, coulomb) in the solution x of `columns`."""
    if design.coulomb == 0:
        return np.zeros((n, 1))
    scale = _COULOMB if design.prior else 1.0
    return np.asarray(scale * x[design.p :].reshape(n, design.coulomb))
