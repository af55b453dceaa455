"""The fit of a form of gravity model to poses: shape of the fields, parameters, outliers, stops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm
from palpate.arm.coupling import coupling, drives
from palpate.arm.gravity_model import GravityModel, Region
from palpate.arrays import Array
from palpate.identify import fit, forms
from palpate.identify.approach import directions
from palpate.identify.forms import Design, Hyper
from palpate.identify.recordings import Static
from palpate.identify.stops import leaning, stop_of

Mask = NDArray[np.bool_]

_TUNED_ON = 200  # poses that shape the fields; all of them determine the parameters
_STEPS = 12  # of the search for that shape; the first look for outliers takes a third of them
_FAR = 5.0  # robust standard deviations: an outlier
_IMPOSSIBLE = 3.0  # times what a drive can: no torque of this arm
_START = Hyper((0.03, 0.03, 0.03), ((0.7, 0.5, 1.2), (1.2,), (2.0, 1.2)), (0.015, 0.03, 0.025, 0.01, 0.005, 0.004, 1.0))


@dataclass(frozen=True)
class Outlier:
    """A torque that does not fit the others, kept out of the fit."""

    pose: int  # row of the recordings, from 0
    joint: int  # from 0
    tau: float  # [N m]
    why: str


@dataclass(frozen=True)
class Fitted:
    """A model, and what its certainty follows from."""

    model: GravityModel
    design: Design
    solution: fit.Solution
    noise: Array  # (n,) what is left unexplained [N m]
    use: Mask  # (k, n) torques it was fitted to
    outliers: tuple[Outlier, ...] = ()

    def columns(self, q: Array, direction: Array, arm: Arm) -> Array:
        """What the torques at q (k, n) are linear in, (k, n, p)."""
        return forms.columns(self.design, q, direction, arm)

    def std(self, q: Array, arm: Arm) -> Array:
        """Standard deviation (k, n) of the holding torques at q: how well the poses determine them [N m]."""
        C = self.columns(q, np.zeros_like(q), arm)
        return np.asarray(np.sqrt(np.einsum("kip,pr,kir->ki", C, self.solution.covariance, C, optimize=True)))


@fit.on_one_core
def fit_poses(poses: Static, arm: Arm, form: str, measured: Mask) -> Fitted:
    """Fit one form to poses; `measured` (n,) are the joints whose torques are known."""
    impossible = beyond_drives(poses.tau, arm)
    use = np.broadcast_to(measured, poses.tau.shape) & ~impossible.any(axis=1, keepdims=True)
    outliers = [_outlier(poses, i, j, "more than three times what the drive can") for i, j in np.argwhere(impossible)]
    if not forms.FORMS[form](arm, poses.q, measured, _START).prior:
        return replace(_fit(poses, arm, form, measured, use), outliers=tuple(outliers))
    leans = leaning(poses.q, poses.tau, use, arm.tau_max)
    for lean in leans:  # what a drive bears is felt by all joints it is coupled to
        use = use & ~(lean.rows[:, None] & (np.abs(np.linalg.inv(coupling(arm)).T[:, lean.joint]) > 0.0))
    fitted = _fit(poses, arm, form, measured, use, _STEPS // 3)
    left = poses.tau - predicted(fitted.model, poses, arm)
    far = use & (np.abs(left) > _FAR * _spread(left, use))
    outliers += [_outlier(poses, i, j, f"{left[i, j]:+.3f} N m from the model") for i, j in np.argwhere(far)]
    fitted = _fit(poses, arm, form, measured, use & ~far, _STEPS)
    left = poses.tau - predicted(fitted.model, poses, arm)
    back = left @ coupling(arm)  # to the drives
    stops = tuple(stop_of(poses.q[:, lean.joint], back[:, lean.joint], lean) for lean in leans)
    return replace(fitted, model=replace(fitted.model, stops=stops), outliers=tuple(outliers))


def beyond_drives(tau: Array, arm: Arm) -> Mask:
    """(k, n) torques that no drive of this arm can give: mistakes of the recording."""
    return np.asarray(np.abs(tau) > _IMPOSSIBLE * arm.tau_max)


def predicted(model: GravityModel, poses: Static, arm: Arm) -> Array:
    """Torques (k, n) of the poses of a recording, in its order of visits."""
    return model.measured(poses.q, arm, directions(poses, model.drives(poses.q, arm)))


def _fit(poses: Static, arm: Arm, form: str, measured: Mask, use: Mask, steps: int = 0) -> Fitted:
    make = forms.FORMS[form]
    x = drives(poses.q, arm)
    hyper = _tuned(poses, arm, form, use, steps) if steps else None
    design = make(arm, poses.q, measured, hyper)
    direction = directions(poses, x if design.motor_friction else poses.q)
    columns = forms.columns(design, poses.q, direction, arm)
    if hyper is not None:
        noise = np.array(hyper.noise)
        solution = fit.bayes(columns, poses.tau, noise, use)
    else:
        solution = fit.least_squares(columns, poses.tau, use)
        left = np.where(use, poses.tau - columns @ solution.x, 0.0)
        noise = np.sqrt((left**2).sum(axis=0) / np.maximum(use.sum(axis=0), 1)) + 1e-9
    model = GravityModel(
        arm=arm.name,
        form=form,
        terms=design.terms,
        theta=design.into @ solution.x[: design.into.shape[1]],
        friction=forms.friction_of(design, solution.x, arm.n),
        motor_friction=design.motor_friction,
        region=Region.of(poses.q, arm),
        visited=poses.q,
    )
    return Fitted(model, design, solution, noise, use)


def _tuned(poses: Static, arm: Arm, form: str, use: Mask, steps: int) -> Hyper:
    """The shape of the fields that makes these torques most likely."""
    rows = np.random.default_rng(0).permutation(len(poses))[:_TUNED_ON]
    q, tau, use = poses.q[rows], poses.tau[rows], use[rows]
    direction = directions(poses, drives(poses.q, arm))[rows]
    joints: Mask = np.asarray(use.any(axis=0))

    @lru_cache(maxsize=4)  # a step in the noise alone leaves the columns as they are
    def columns(size: tuple[float, ...], length: tuple[tuple[float, ...], ...]) -> Array:
        design = forms.FORMS[form](arm, q, joints, replace(_START, size=size, length=length))
        return np.ascontiguousarray(forms.columns(design, q, direction, arm)[:, joints])

    def objective(values: Array) -> float:
        hyper = _hyper(values, joints)
        noise = np.array(hyper.noise)[joints]
        return fit.evidence(columns(hyper.size, hyper.length), tau[:, joints], noise, use[:, joints])

    start = np.concatenate([_START.size, *_START.length, np.array(_START.noise)[joints]])
    least = np.full_like(start, 1e-4)  # below it no torque is known, and
    # no field is wavier than the poses can show
    crossed = [joint for bundle in forms.BUNDLES for joint in bundle]
    least[len(forms.BUNDLES) :][: len(crossed)] = np.diff(np.sort(poses.q[:, crossed], axis=0), axis=0).max(axis=0)
    return _hyper(fit.most_likely(objective, start, least, steps), joints)


def _hyper(values: Array, joints: Mask) -> Hyper:
    sizes = len(forms.BUNDLES)
    lengths, at = [], sizes
    for bundle in forms.BUNDLES:
        lengths.append(tuple(values[at : at + len(bundle)].tolist()))
        at += len(bundle)
    noise = np.array(_START.noise)
    noise[joints] = values[at:]
    return Hyper(tuple(values[:sizes].tolist()), tuple(lengths), tuple(noise.tolist()))


def _outlier(poses: Static, pose: int, joint: int, why: str) -> Outlier:
    return Outlier(int(pose), int(joint), float(poses.tau[pose, joint]), why)


def _spread(left: Array, use: Mask) -> Array:
    """Robust standard deviation (n,) of what is left."""
    return np.array([1.4826 * np.median(np.abs(x[u])) if u.any() else 0.0 for x, u in zip(left.T, use.T, strict=True)])
