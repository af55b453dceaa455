"""Fit of a gravity model to poses: hyperparameters of the fields, parameters, outliers and stops."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from palpate.arm import Arm
from palpate.arm.coupling import coupling, drives
from palpate.arm.gravity_model import GravityModel, TrainingRegion
from palpate.arm.identify import fit, forms
from palpate.arm.identify.approach import directions
from palpate.arm.identify.forms import Design, Hyper
from palpate.arm.identify.recordings import Static
from palpate.arm.identify.stops import leaning, stop_of
from palpate.base.arrays import Array

Mask = NDArray[np.bool_]

_TUNED_ON = 200  # poses used to tune the hyperparameters; the parameters are fitted to all poses
_STEPS = 12  # iterations of that tuning; the first fit, which finds outliers, takes a third of them
_DIFFERENCE = 1e-6  # step of the logarithm of a length, whose derivative is a difference
_FAR = 5.0  # residual of an outlier, in robust standard deviations
_IMPOSSIBLE = 3.0  # torques above this multiple of a drive's limit are recording errors
_START = Hyper((0.03, 0.03, 0.03), ((0.7, 0.5, 1.2), (1.2,), (2.0, 1.2)), (0.015, 0.03, 0.025, 0.01, 0.005, 0.004, 1.0))


@dataclass(frozen=True)
class Outlier:
    """A torque that is excluded from the fit."""

    pose: int  # row of the recordings, from 0
    joint: int  # from 0
    tau: float  # [N m]
    why: str


@dataclass(frozen=True)
class Fitted:
    """A fitted model, with the design and covariance that give its uncertainty."""

    model: GravityModel
    design: Design
    solution: fit.Solution
    noise: Array  # (n,) standard deviation of the residual [N m]
    use: Mask  # (k, n) torques it was fitted to
    outliers: tuple[Outlier, ...] = ()

    def columns(self, q: Array, direction: Array, arm: Arm) -> Array:
        """Regressor (k, n, p) of the torques at q (k, n)."""
        return forms.columns(self.design, q, direction, arm)

    def std(self, q: Array, arm: Arm) -> Array:
        """Standard deviation (k, n) of the holding torques at q (k, n), from the covariance of the fit [N m]."""
        C = self.columns(q, np.zeros_like(q), arm)
        return np.asarray(np.sqrt(np.einsum("kip,pr,kir->ki", C, self.solution.covariance, C, optimize=True)))


@fit.on_one_core
def fit_poses(poses: Static, arm: Arm, form: str, measured: Mask) -> Fitted:
    """Fit one form of model to poses; `measured` (n,) marks the joints whose torques were measured."""
    impossible = beyond_drives(poses.tau, arm)
    use = np.broadcast_to(measured, poses.tau.shape) & ~impossible.any(axis=1, keepdims=True)
    outliers = [_outlier(poses, i, j, "more than three times what the drive can") for i, j in np.argwhere(impossible)]
    if not forms.FORMS[form](arm, poses.q, measured, _START).prior:
        return replace(_fit(poses, arm, form, measured, use), outliers=tuple(outliers))
    leans = leaning(poses.q, poses.tau, use, arm.tau_max)
    for lean in leans:  # the torque of a drive acts on all joints that it is coupled to
        use = use & ~(lean.rows[:, None] & (np.abs(np.linalg.inv(coupling(arm)).T[:, lean.joint]) > 0.0))
    fitted = _fit(poses, arm, form, measured, use, _STEPS // 3)
    residual = poses.tau - predicted(fitted.model, poses, arm)
    far = use & (np.abs(residual) > _FAR * _spread(residual, use))
    outliers += [_outlier(poses, i, j, f"{residual[i, j]:+.3f} N m from the model") for i, j in np.argwhere(far)]
    fitted = _fit(poses, arm, form, measured, use & ~far, _STEPS)
    residual = poses.tau - predicted(fitted.model, poses, arm)
    drive_residual = residual @ coupling(arm)
    stops = tuple(stop_of(poses.q[:, lean.joint], drive_residual[:, lean.joint], lean) for lean in leans)
    return replace(fitted, model=replace(fitted.model, stops=stops), outliers=tuple(outliers))


def beyond_drives(tau: Array, arm: Arm) -> Mask:
    """(k, n) mask of torques that no drive of this arm can apply: recording errors."""
    return np.asarray(np.abs(tau) > _IMPOSSIBLE * arm.tau_max)


def predicted(model: GravityModel, poses: Static, arm: Arm) -> Array:
    """Measured torques (k, n) that the model predicts for poses in their order of visits [N m]."""
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
        solution, noise = fit.least_squares(columns, poses.tau, use)
        noise = noise + 1e-9
    model = GravityModel(
        arm=arm.name,
        form=form,
        terms=design.terms,
        theta=design.into @ solution.x[: design.p],
        friction=forms.friction_of(design, solution.x, arm.n),
        motor_friction=design.motor_friction,
        region=TrainingRegion.of(poses.q, arm),
        visited=poses.q,
    )
    return Fitted(model, design, solution, noise, use)


def _tuned(poses: Static, arm: Arm, form: str, use: Mask, steps: int) -> Hyper:
    """Hyperparameters that maximise the marginal likelihood of these torques."""
    rows = np.random.default_rng(0).permutation(len(poses))[:_TUNED_ON]
    q, tau, use = poses.q[rows], poses.tau[rows], use[rows]
    direction = directions(poses, drives(poses.q, arm))[rows]
    joints: Mask = np.asarray(use.any(axis=0))
    design = forms.FORMS[form](arm, q, joints, _START)
    start_columns = np.ascontiguousarray(forms.columns(design, q, direction, arm)[:, joints])
    ends = np.cumsum([block.shape[1] for block in design.blocks])[-len(forms.BUNDLES) - 1 :]
    places = [slice(int(a), int(b)) for a, b in pairwise(ends)]  # of the columns of each bundle

    @lru_cache(maxsize=4 * len(places))
    def unit(bundle: int, length: tuple[float, ...]) -> Array:
        return forms.field_columns(arm, q, bundle, length)[:, joints]

    def evidence(hyper: Hyper) -> fit.Evidence:
        columns = start_columns.copy()
        for bundle, place in enumerate(places):
            columns[:, :, place] = hyper.size[bundle] * unit(bundle, hyper.length[bundle])
        return fit.Evidence(columns, tau[:, joints], np.array(hyper.noise)[joints], use[:, joints])

    def objective(values: Array) -> tuple[float, Array]:
        """Log marginal likelihood, and its derivatives with respect to the logarithms of the values."""
        here = evidence(_hyper(values, joints))
        sizes = [here.by_size(place) for place in places]
        lengths = []
        for k in range(len(places), len(values) - int(joints.sum())):
            moved = values.copy()
            moved[k] *= np.exp(_DIFFERENCE)
            lengths.append((evidence(_hyper(moved, joints)).value - here.value) / _DIFFERENCE)
        return here.value, np.concatenate([sizes, lengths, here.by_noise()])

    start = np.concatenate([_START.size, *_START.length, np.array(_START.noise)[joints]])
    # Lower bounds: torques are not measured more finely than 0.1 mN m, and no field varies over less than the largest
    # distance between neighbouring poses.
    least = np.full_like(start, 1e-4)
    crossed = [joint for bundle in forms.BUNDLES for joint in bundle]
    least[len(forms.BUNDLES) :][: len(crossed)] = np.diff(np.sort(poses.q[:, crossed], axis=0), axis=0).max(axis=0)
    return _hyper(fit.most_likely(objective, start, least, steps), joints)


def _hyper(values: Array, joints: Mask) -> Hyper:
    sizes = len(forms.BUNDLES)
    lengths, i = [], sizes
    for bundle in forms.BUNDLES:
        lengths.append(tuple(values[i : i + len(bundle)].tolist()))
        i += len(bundle)
    noise = np.array(_START.noise)
    noise[joints] = values[i:]
    return Hyper(tuple(values[:sizes].tolist()), tuple(lengths), tuple(noise.tolist()))


def _outlier(poses: Static, pose: int, joint: int, why: str) -> Outlier:
    return Outlier(int(pose), int(joint), float(poses.tau[pose, joint]), why)


def _spread(residual: Array, use: Mask) -> Array:
    """Robust standard deviation (n,) of the residual (k, n)."""
    return np.array(
        [1.4826 * np.median(np.abs(x[u])) if u.any() else 0.0 for x, u in zip(residual.T, use.T, strict=True)]
    )
