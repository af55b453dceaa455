"""What poses can tell about an arm's masses: rank, condition, base parameters, and which poses would tell more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from palpate import _core
from palpate.arm import Arm
from palpate.arm.coupling import coupling
from palpate.arm.gravity_model import Region
from palpate.arrays import Array
from palpate.identify.fit_gravity import Fitted

_NOTHING = 1e-9  # of the largest singular value: a column that never moves a joint
_WIDER = 0.05  # [rad]
_WEAK = 1e-3  # of what poses all over the limits would tell: too little


@dataclass(frozen=True)
class Identifiability:
    """Of the links' masses and first moments by static torques."""

    rank: int  # of the poses' regressor
    structural_rank: int  # of any poses within the limits, joints that never moved held still
    condition: float  # of the base columns, as they are (SI units)
    base: tuple[str, ...]  # base parameters: a parameter, with those that cannot be told from it
    never: tuple[str, ...]  # parameters without any effect on these joints
    weak: tuple[str, ...]  # base parameters that these poses do not show


def names(arm: Arm) -> list[str]:
    """Pi by name: mass and first moments of each link, called by its joint."""
    return [f"{joint}.{part}" for joint in arm.joint_names for part in ("m", "mx", "my", "mz")]


def identifiability(q: Array, joints: NDArray[np.bool_], arm: Arm) -> Identifiability:
    """What torques of `joints` (n,) at poses q (k, n) tell."""
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
    told = names(arm)
    seen = Y[:, base] / sizes[base] * np.sqrt(len(Y0) / len(Y))
    values, V = np.linalg.svd(seen, full_matrices=False)[1:]
    lost = values < _WEAK * np.linalg.svd(Y0[:, base] / sizes[base], compute_uv=False)[: len(values)]
    weak = np.sqrt((V[lost] ** 2).sum(axis=0)) > 0.3 if len(values) == rank0 else np.ones(rank0, dtype=bool)
    kept = np.linalg.svd(Y[:, base], compute_uv=False)
    rank = int((~lost).sum())
    return Identifiability(
        rank=rank,
        structural_rank=rank0,
        condition=float(kept[0] / kept[rank - 1]) if rank else float("inf"),
        base=tuple(_sum(told[b], [(share[i, j], told[r]) for j, r in enumerate(rest)]) for i, b in enumerate(base)),
        never=tuple(told[r] for r in rest if sizes[r] < _NOTHING * sizes.max()),
        weak=tuple(told[b] for b, w in zip(base, weak, strict=True) if w),
    )


def _sum(first: str, others: list[tuple[float, str]]) -> str:
    return first + "".join(f" {c:+.4g} {name}" for c, name in others if abs(c) > 1e-9)


def next_poses(fitted: Fitted, joints: NDArray[np.bool_], arm: Arm, count: int = 6) -> list[tuple[Array, float]]:
    """Poses (n,) that would tell most next, with the information each adds [nat]: greedy D-optimal.

    Within the arm's limits, and near the drives' ranges so far: a parallelogram has limits that no joint shows.
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


def _reachable(region: Region, joints: NDArray[np.bool_], arm: Arm) -> Array:
    """Random poses (k, n) within the joint limits and about the drives' ranges; joints that never moved stay."""
    low, high = region.motor_min - _WIDER, region.motor_max + _WIDER
    q = np.random.default_rng(1).uniform(low, high, (4000, arm.n)) @ coupling(arm).T
    q[:, ~joints] = 0.5 * (region.q_min + region.q_max)[~joints]
    return np.asarray(q[((q >= arm.q_min) & (q <= arm.q_max)).all(axis=1)])
