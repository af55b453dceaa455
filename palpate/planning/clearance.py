"""The smallest distance from the obstacles along a whole path: sampled, refined, and proved within 0.2 mm."""

from __future__ import annotations

import numpy as np

from palpate.base.arrays import Array
from palpate.planning.checker import Checker, Nearest
from palpate.planning.result import Clearance
from palpate.planning.timing import Trajectory

_TOLERANCE = 2e-4  # the smallest distance is known to this [m]
_SAMPLES = 32  # places along the path that are always examined
_REFINED = 8  # halvings of the stretch around the smallest sample
_PROOFS = 3  # attempts to prove the smallest distance

Seen = dict[tuple[int, float], Nearest | None]
"""The nearest pair at places: index of the curve and s in 0..1."""


def along(checker: Checker, trajectory: Trajectory) -> Clearance:
    """Distance over time, and the smallest one: a proof excludes any place that is nearer by more than 0.2 mm."""
    curves = trajectory.curves
    seen: Seen = {}

    def examine(k: int, s: float) -> float:
        if (k, s) not in seen:
            found = checker.nearest(curves[k].at(np.array([s]))[0])
            seen[k, s] = found[0] if found else None
        one = seen[k, s]
        return np.inf if one is None else one.distance

    lengths = np.array([np.linalg.norm(trajectory.scale * (c.controls[-1] - c.controls[0])) for c in curves])
    for k, share in enumerate(lengths / max(float(lengths.sum()), 1e-12)):
        for s in np.linspace(0.0, 1.0, 2 + round(_SAMPLES * float(share))):
            examine(k, float(s))
    for _ in range(_PROOFS):
        (k, s), least = _least(seen)
        if not np.isfinite(least):
            break
        width = 0.5 / _SAMPLES
        for _ in range(_REFINED):
            s = min((max(s - width, 0.0), s, min(s + width, 1.0)), key=lambda x: examine(k, x))
            width *= 0.5
        bound = _least(seen)[1] - _TOLERANCE
        closer = next(((i, b.s) for i, c in enumerate(curves) if (b := checker.blocked(c, bound)) is not None), None)
        if closer is None or closer in seen:
            break
        examine(*closer)
    return _summary(trajectory, seen)


def _least(seen: Seen) -> tuple[tuple[int, float], float]:
    place = min(seen, key=lambda row: np.inf if (one := seen[row]) is None else one.distance)
    one = seen[place]
    return place, np.inf if one is None else one.distance


def _summary(trajectory: Trajectory, seen: Seen) -> Clearance:
    rows = sorted(seen)
    t = np.array([trajectory.time_at(k, s) for k, s in rows])
    distance = np.array([np.inf if (one := seen[row]) is None else one.distance for row in rows])
    pairs = [("", "") if (one := seen[row]) is None else one.pair for row in rows]
    least = int(np.argmin(distance))
    nearest = seen[rows[least]]
    place: Array = np.full(3, np.nan) if nearest is None else nearest.p_world_W
    return Clearance(t, distance, pairs, float(distance[least]), pairs[least], float(t[least]), place)
