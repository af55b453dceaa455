"""Identifiability of an arm's masses from poses: rank, condition, base parameters, and the best further poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from palpate import _core
from palpate.arm import Arm
from palpate.arm.coupling import coupling
from palpate.arm.gravity_model import TrainingRegion
from palpate.arm.identify.fit_gravity import Fitted
from palpate.base.arrays import Array

_NOTHING = 1e-9  # relative size below which a column has no effect on any joint
_WIDER = 0.05  # margin by which suggested poses may exceed the drives' ranges so far [rad]
_WEAK = 1e-3  # singular value below which a direction counts as not identified, relative to poses over the full range


@dataclass(frozen=True)
class Identifiability:
    """Identifiability of the links' masses and first moments from static torques."""

    rank: int  # rank of the regressor of the poses
    structural_rank: int  # rank over all poses within the limits, with joints that never moved held still
    condition: float  # condition number of the base columns, unscaled (SI units)
    base: tuple[str, ...]  # base parameters: a parameter plus those that cannot be separated from it
    never: tuple[str, ...]  # parameters without effect on these joints
    weak: tuple[str, ...]  # base parameters that these poses do not identify


def names(arm: Arm) -> list[str]:
    """Names of the parameters Pi: mass and first moments of each link, prefixed by its joint."""
    return [f"{joint}.{part}" for joint in arm.joint_names for part in ("m", "mx", "my", "mz")]


def identifiability(q: Array, joints: NDArray[np.bool_], arm: Arm) -> Identifiability:
    """Identifiability from the torques of `joints` (n,) at poses q (k, n)."""
    anywhere = np.random.default_rng(0).uniform(arm.q_min, arm.q_max, (200, arm.n))
    anywhere[:, ~joints] = q[:, ~joints].mean(axis=0)
    Y = arm.gravity_columns(_core.GravityTerms(), q)[:, joints].reshape(-1, 4 * arm.n)
    Y0 = arm.gravity_columns(_core.GravityTerms(), anywhere)[:, joints].reshape(-1, 4 * arm.n)
    sizes = np.linalg.norm(Y0, axis=0)
    _, R, order = linalg.qr(Y0, mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(R))
    rank0 = int((diagonal > _NOTHING * diagonal[0]).sum())
    base, rest = order[:rank0], order[rank0:]
    share = linalg.solve_triangular(R[:rank0, :rank0], R[:rank0, rank0:])  # Y0[:, rest] = Y0[:, base] @ share
    parameter = names(arm)
    seen = Y[:, base] / sizes[base] * np.sqrt(len(Y0) / len(Y))
    values, V = np.linalg.svd(seen, full_matrices=False)[1:]
    unseen = values < _WEAK * np.linalg.svd(Y0[:, base] / sizes[base], compute_uv=False)[: len(values)]
    weak = np.sqrt((V[unseen] ** 2).sum(axis=0)) > 0.3 if len(values) == rank0 else np.ones(rank0, dtype=bool)
    kept = np.linalg.svd(Y[:, base], compute_uv=False)
    rank = int((~unseen).sum())
    return Identifiability(
        rank=rank,
        structural_rank=rank0,
        condition=float(kept[0] / kept[rank - 1]) if rank else float("inf"),
        base=tuple(
            _sum(parameter[b], [(share[i, j], parameter[r]) for j, r in enumerate(rest)]) for i, b in enumerate(base)
        ),
        never=tuple(parameter[r] for r in rest if sizes[r] < _NOTHING * sizes.max()),
        weak=tuple(parameter[b] for b, w in zip(base, weak, strict=True) if w),
    )


def _sum(first: str, others: list[tuple[float, str]]) -> str:
    return first + "".join(f" {c:+.4g} {name}" for c, name in others if abs(c) > 1e-9)


def next_poses(fitted: Fitted, joints: NDArray[np.bool_], arm: Arm, count: int = 6) -> list[tuple[Array, float]]:
    """Further poses (n,) that add most information, with the information each adds [nat]: greedy D-optimal.

    They lie within the joint limits and near the drives' ranges so far, because a parallelogram has further limits that
    no joint limit expresses.
    """
    q = _reachable(fitted.model.region, joints, arm)[:300]
    C = fitted.columns(q, np.zeros_like(q), arm)[:, joints] / fitted.noise[joints][:, None]
    S, found = fitted.solution.covariance, []
    for _ in range(min(count, len(q))):
        inner = np.eye(C.shape[1]) + np.einsum("kip,pr,kjr->kij", C, S, C, optimize=True)
        gain = 0.5 * np.linalg.slogdet(inner)[1]
        best = int(np.argmax(gain))
        found.append((q[best], float(gain[best])))
        SC = S @ C[best].T
        S = S - SC @ np.linalg.solve(inner[best], SC.T)
    return found


def _reachable(region: TrainingRegion, joints: NDArray[np.bool_], arm: Arm) -> Array:
    """Random poses (k, n) within the joint limits and near the drives' ranges; unmeasured joints stay fixed."""
    low, high = region.motor_min - _WIDER, region.motor_max + _WIDER
    q = np.random.default_rng(1).uniform(low, high, (4000, arm.n)) @ coupling(arm).T
    q[:, ~joints] = 0.5 * (region.q_min + region.q_max)[~joints]
    return np.asarray(q[((q >= arm.q_min) & (q <= arm.q_max)).all(axis=1)])
