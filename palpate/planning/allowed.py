"""Pairs of bodies of one instrument that need no check, derived as MoveIt's setup assistant derives them."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from palpate.planning.kinematics import Kinematics
from palpate.planning.own import OwnPairs
from palpate.planning.robot import Placed, Robot

_SAMPLES = 2000  # configurations in which pairs are examined
_MOSTLY = 0.9  # capsules in contact in more than this fraction of the samples are always in contact
_NEARLY_ALWAYS = 0.95  # the same for meshes and primitives
_CACHE: dict[tuple[Hashable, ...], list[tuple[int, int]]] = {}


@dataclass(frozen=True)
class DisabledPair:
    """Two links that may touch, with the reason: Adjacent, Cannula, Linkage, Default (always in contact) or Never."""

    one: str
    two: str
    reason: str


def checked_pairs(robot: Robot) -> list[tuple[int, int]]:
    """Pairs (i, j) of bodies of the robot that can collide with each other and are therefore checked."""
    key = (robot.arm.urdf, robot.arm.folder, robot.span, tuple(held.name for held in robot.attached))
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
    placed = robot.placed(q)
    members: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for i, j in combinations(range(len(bodies)), 2):
        if bodies[i].carrier != bodies[j].carrier:
            members.setdefault((bodies[i].link, bodies[j].link), []).append((i, j))
    checked: list[tuple[int, int]] = []
    disabled: list[DisabledPair] = []
    for (one, two), pairs in members.items():
        reason = _by_structure(robot, one, two) or _by_samples(placed, OwnPairs(robot, np.array(pairs)))
        if reason:
            disabled.append(DisabledPair(one, two, reason))
        else:
            checked += pairs
    return checked, disabled


def _by_samples(placed: Placed, own: OwnPairs) -> str:
    """Reason to leave out a pair of links that always or never touches; the first of the samples is home.

    Meshes and primitives touch at home by a wrong home, not by too much room around them: these are left out only if
    they touch nearly everywhere. That they never touch is believed where even the capsules around them never do.
    """
    low = own.low(placed)
    if (low > 0.0).all():
        return "Never"
    touch = np.logical_and(low <= 0.0, ~own.exact)
    if not own.exact.any():
        apart = ~touch.any(axis=1)
        return "Default" if not apart[0] or apart.mean() < 1.0 - _MOSTLY else ""
    free, most = 0, (1.0 - _NEARLY_ALWAYS) * len(low)
    for k in range(len(low)):
        exact = np.nonzero(own.exact & (low[k] <= 0.0))[0]
        free += not (touch[k].any() or any(own.touches(placed, k, int(pair), 0.0) is not None for pair in exact))
        if free > most:
            return ""
    return "Default"


def _by_structure(robot: Robot, one: str, two: str) -> str:
    """Reason to leave out a pair of links whatever their shapes are."""
    kin = robot.kinematics
    a, b = kin.mount[one][0], kin.mount[two][0]
    if any(x >= 0 and kin.joints[x].parent == y for x, y in ((a, b), (b, a))):
        return "Adjacent"
    if any(x >= 0 and kin.joints[x].name != robot.arm.joint_names[kin.joints[x].source] for x in (a, b)):
        return "Linkage"  # bars that mimic a joint, whose own limits keep them apart
    if robot.arm.has_remote_centre and _through_cannula(kin, a, b):
        return "Cannula"
    return ""


def _through_cannula(kin: Kinematics, a: int, b: int) -> bool:
    """True if one link holds the cannula, which is the link before the insertion, and the other is behind it."""
    slides = [j.parent for j in kin.joints if not j.turns]
    return bool(slides) and slides[0] in (a, b) and bool(kin.moves[max(a, b), slides[0]])
