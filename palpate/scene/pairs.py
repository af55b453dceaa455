"""Section `pairs` of a scene: several leaders with their followers, which share the objects."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import combinations
from typing import Any

from palpate.base.arrays.plain import Content
from palpate.base.errors import ValueAtError
from palpate.base.values import NotNegative, Positive, Section
from palpate.scene.force import ForceSection
from palpate.scene.guidance.lists import FixtureList
from palpate.scene.mapping import MappingSection
from palpate.scene.model import ArmsSection, ContactSection, TorqueSection
from palpate.scene.operator import OperatorSection
from palpate.scene.stability import StabilitySection

MOST = 8
"""Largest number of pairs in a scene."""
_NAME = re.compile(r"[a-z][a-z0-9_]*")


class DevicesSection(Section):
    """Names of a pair's arms on ROS 2 (palpate ros haptics)."""

    leader: str
    """CRTK name of the leader, e.g. MTML"""
    follower: str = "virtual"
    """CRTK name of the follower, e.g. PSM2; virtual: the tool follows the hand exactly"""
    teleop: str = "none"
    """running teleoperation component, e.g. MTML_PSM2; none: Palpate moves the follower"""


class PairSection(Section):
    """A leader with its follower. Each section is as in the scene; keys that are left out have the scene's values."""

    arms: ArmsSection | None = None
    """leader and follower, with their bases"""
    devices: DevicesSection | None = None
    """names of the arms on ROS 2"""
    mapping: MappingSection | None = None
    """mapping of motion from hand to tool, and of force from tool to hand"""
    contact: ContactSection | None = None
    """contact method and geometry of the tool"""
    force: ForceSection | None = None
    """source of the force on the tool"""
    guidance: FixtureList | None = None
    """virtual fixtures of this pair; they replace those of the scene"""
    stability: StabilitySection | None = None
    """limits and passivity of the force"""
    torque: TorqueSection | None = None
    """joint torques of the leader"""
    operator: OperatorSection | None = None
    """the simulated hand"""


class InstrumentsSection(Section):
    """Contact between the instruments of different pairs, and the distance between their leaders' handles."""

    stiffness: NotNegative = 500.0
    """stiffness with which two instruments push each other apart; 0: they pass through each other [N/m]"""
    damping: NotNegative = 1.0
    """damping of this contact [N s/m]"""
    handle_distance: Positive = 0.08
    """a warning appears when the handles of two leaders are closer than this [m]"""


def check(pairs: Mapping[str, PairSection]) -> None:
    """Refuse unusable names, too many pairs, and an arm or a device that two pairs name.

    Raises:
        ValueAtError: the message states the pairs and the arm.
    """
    for name in pairs:
        if not _NAME.fullmatch(name):
            what = f"{name!r} cannot name a pair: small letters, digits and _ only, a letter first"
            raise ValueAtError(f"{what} | e.g. left or right_hand", "pairs", name)
    if len(pairs) > MOST:
        raise ValueAtError(f"{len(pairs)} pairs; at most {MOST} are possible | remove some", "pairs")
    for (one, a), (other, b) in combinations(pairs.items(), 2):
        for key, x, y in _identities(a, b):
            if x is not None and x == y and x not in ("virtual", "none"):
                what = f"the pairs {one} and {other} both have the {key.replace('.', ' ')} {x!r}"
                mend = "an arm belongs to one pair: name another, or remove a pair"
                raise ValueAtError(f"{what} | {mend}", "pairs", other, *key.split("."))


def _identities(a: PairSection, b: PairSection) -> list[tuple[str, str | None, str | None]]:
    """Keys that identify a device or an arm, with their values in two pairs."""
    drivers = [None if p.arms is None else p.arms.leader.driver for p in (a, b)]
    found: list[tuple[str, str | None, str | None]] = [("arms.leader.driver", drivers[0], drivers[1])]
    if a.devices is not None and b.devices is not None:
        for key in ("leader", "follower", "teleop"):
            found.append((f"devices.{key}", getattr(a.devices, key), getattr(b.devices, key)))
    return found


def merged(data: Content, own: Content) -> Content:
    """Sections of a pair over those of the scene, key by key; arms one level deeper."""
    out = dict(data)
    if "path" in (own.get("operator") or {}) and isinstance(out.get("operator"), dict):  # instead of an automatic path
        out["operator"] = {key: value for key, value in out["operator"].items() if key != "palpate"}
    for section, values in own.items():
        if values is None:  # a section without keys
            continue
        below: Any = out.get(section)
        if section == "arms" and isinstance(below, dict):
            out[section] = {**below, **{side: {**below.get(side, {}), **arm} for side, arm in values.items()}}
        else:
            out[section] = {**below, **values} if isinstance(below, dict) and isinstance(values, dict) else values
    return out
