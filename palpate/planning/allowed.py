"""Pairs of bodies of one instrument that need no check, derived as MoveIt's setup assistant derives them."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from palpate.arrays import Array
from palpate.planning.kinematics import Kinematics
from palpate.planning.robot import Robot

_SAMPLES = 2000  # configurations in which pairs are examined
_MOSTLY = 0.9  # pairs in contact in more than this fraction of the samples are always in contact
_CACHE: dict[tuple[str, float, int], list[tuple[int, int]]] = {}


@dataclass(frozen=True)
class DisabledPair:
    """Two links that may touch, with the reason: Adjacent, Cannula, Linkage, Default (always in contact) or Never."""

    one: str
    two: str
    reason: str


def checked_pairs(robot: Robot) -> list[tuple[int, int]]:
    """Pairs (i, j) of bodies of the robot that can collide with each other and are therefore checked."""
    key = (robot.arm.urdf, robot.jaw, len(robot.attached))
    if key not in _CACHE:
        _CACHE[key] = _examine(robot)[0]
    return _CACHE[key]


def disabled_pairs(robot: Robot) -> list[DisabledPair]:
    """Pairs of links that are not checked, with their reasons, as the list of an SRDF."""
    return _examine(robot)[1]


def _examine(robot: Robot) -> tuple[list[tuple[int, int]], list[DisabledPair]]:
    """Pairs of bodies to check, and disabled pairs of links."""
    arm, bodies = robot.arm, robot.bodies
    rng = np.random.default_rng(0)
    q = np.vstack([arm.home, rng.uniform(arm.q_min, arm.q_max, (_SAMPLES, arm.n))])
    ends = robot.placed(q).ends_W
    touch: dict[tuple[str, str], Array] = {}
    members: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for i, j in combinations(range(len(bodies)), 2):
        if bodies[i].carrier != bodies[j].carrier:
            key = (bodies[i].link, bodies[j].link)
            apart = segment_distance(ends[:, i], ends[:, j]) - robot.radii[i] - robot.radii[j]
            touch[key] = np.minimum(touch.get(key, np.inf), apart)
            members.setdefault(key, []).append((i, j))
    checked: list[tuple[int, int]] = []
    disabled: list[DisabledPair] = []
    for (one, two), apart in touch.items():
        reason = _reason(robot, one, two, apart)
        if reason:
            disabled.append(DisabledPair(one, two, reason))
        else:
            checked += members[one, two]
    return checked, disabled


def _reason(robot: Robot, one: str, two: str, apart: Array) -> str:
    kin = robot.kinematics
    a, b = kin.mount[one][0], kin.mount[two][0]
    if any(x >= 0 and kin.joints[x].parent == y for x, y in ((a, b), (b, a))):
        return "Adjacent"
    if any(x >= 0 and kin.joints[x].name != robot.arm.joint_names[kin.joints[x].source] for x in (a, b)):
        return "Linkage"  # bars that mimic a joint, whose own limits keep them apart
    if robot.arm.has_remote_centre and _through_cannula(kin, a, b):
        return "Cannula"
    if apart[0] <= 0.0 or (apart <= 0.0).mean() > _MOSTLY:
        return "Default"
    return "Never" if apart.min() > 0.0 else ""


def _through_cannula(kin: Kinematics, a: int, b: int) -> bool:
    """True if one link holds the cannula, which is the link before the insertion, and the other is behind it."""
    slides = [j.parent for j in kin.joints if not j.turns]
    return bool(slides) and slides[0] in (a, b) and bool(kin.moves[max(a, b), slides[0]])


def segment_distance(one: Array, two: Array) -> Array:
    """Distances (K,) [m] between the segments one and two (K, 2, 3) [m], in closed form.

    Source: Ericson, Real-Time Collision Detection, 2005, section 5.1.9.
    """
    p1, p2 = one[:, 0], two[:, 0]
    d1, d2, r = one[:, 1] - p1, two[:, 1] - p2, p1 - p2
    a, e, f = (d1 * d1).sum(-1), (d2 * d2).sum(-1), (d2 * r).sum(-1)
    c, b = (d1 * r).sum(-1), (d1 * d2).sum(-1)
    a, e = np.maximum(a, 1e-18), np.maximum(e, 1e-18)
    denominator = a * e - b * b
    s = np.clip(np.where(denominator > 1e-18, (b * f - c * e) / np.maximum(denominator, 1e-18), 0.0), 0.0, 1.0)
    t = (b * s + f) / e
    s = np.where(t < 0.0, np.clip(-c / a, 0.0, 1.0), np.where(t > 1.0, np.clip((b - c) / a, 0.0, 1.0), s))
    t = np.clip(t, 0.0, 1.0)
    return np.asarray(np.linalg.norm(r + s[:, None] * d1 - t[:, None] * d2, axis=-1))
