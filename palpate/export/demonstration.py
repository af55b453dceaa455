"""What is exported: one run with its arms, from a record, from the records of several pairs, or from a ROS 2 bag."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import Any

from palpate.arm import NAMES, Arm
from palpate.base.arrays.plain import Content
from palpate.base.arrays.yaml_loader import load
from palpate.base.errors import PalpateError, RecordError
from palpate.export.bag_ticks import BagTicks
from palpate.record.bags.bag import Bag
from palpate.record.bags.open import open_any
from palpate.record.reader import Record
from palpate.report.pairs import pair_records

NEEDED = ("p_WT", "quat_WT")
"""Signals without which a record holds no follower."""
_LEADERS = {"mtm_left": "mtml", "mtm_right": "mtmr"}  # names by model


@dataclass(frozen=True)
class ArmOfRun:
    """One pair of leader and follower in a run."""

    name: str
    """Name of the follower in lower case: psm1."""
    leader: str
    """Name of the leader in lower case: mtmr."""
    ticks: Record | BagTicks
    scene: Content
    """The resolved scene of the pair; empty for a bag without one."""

    def model(self, side: str) -> str:
        """Name of the model of ``leader`` or ``follower``; empty if unknown."""
        return Path(str(_at(self.scene, "arms", side, "model") or "")).stem

    def joint_names(self, side: str) -> list[str]:
        """Names of the joints of an arm; those of a number when the model is not one of Palpate's."""
        model = self.model(side)
        if model in NAMES:
            return list(Arm.model(model).joint_names)
        return [f"joint_{k}" for k in range(self.ticks.joints(side) if isinstance(self.ticks, BagTicks) else 7)]


@dataclass(frozen=True)
class Demonstration:
    """One run."""

    name: str
    """Short name for files and messages."""
    path: Path
    arms: tuple[ArmOfRun, ...]
    faults: tuple[str, ...] = ()
    """Faults of the run, in words."""

    @property
    def rate(self) -> float:
        """Ticks per second [Hz]."""
        return self.arms[0].ticks.rate

    @property
    def task(self) -> str:
        """The instruction that the scene suggests."""
        scene = self.arms[0].scene
        thing = _at(scene, "operator", "palpate", "object") or _at(scene, "objects", 0, "name")
        if thing and _at(scene, "operator", "path") is None:
            return f"palpate the {thing}"
        return re.sub(r"[-_]+", " ", self.name)


def demonstrations(paths: Iterable[str | Path]) -> list[Demonstration]:
    """Open runs: records, folders of runs, folders of runs of several pairs, and ROS 2 bags.

    Raises:
        RecordError: one cannot be read, is cut off, or holds no follower. PalpateError: there are none.
    """
    found: dict[str, Demonstration] = {}
    for path in map(Path, paths):
        opened = _open(path)
        name = free_name(opened.name, found)
        found[name] = replace(opened, name=name)
    if not found:
        raise PalpateError("there is no record to export", mend="give at least one record.mcap, or the folder of a run")
    return list(found.values())


def free_name(name: str, taken: Collection[str]) -> str:
    """The name itself, or with the first number from 2 on with which it is not taken: run-2."""
    return next(one for one in chain([name], (f"{name}-{k}" for k in count(2))) if one not in taken)


def leader_name(model: str, number: int, taken: Collection[str] = ()) -> str:
    """Name of the leader of pair `number` in lower case: mtmr by its model, or by the number where that is taken."""
    name = _LEADERS.get(Path(model).stem, "")
    return name if name and name not in taken else f"leader{number}"


def _open(path: Path) -> Demonstration:
    pairs = pair_records(path)
    if pairs:
        records = [Record.open(file) for file in pairs.values()]
        return _of_records(path.resolve().name, path, records)
    opened = open_any(path)
    if isinstance(opened, Bag):
        return _of_bag(path, opened)
    stem = opened.path.resolve().parent.name if opened.path.stem == "record" else opened.path.stem
    return _of_records(stem, path, [opened])


def _of_records(name: str, path: Path, records: Sequence[Record]) -> Demonstration:
    arms: list[ArmOfRun] = []
    for k, record in enumerate(records, start=1):
        _require_whole(record)
        scene = _mapping(record.scene)
        model = str(_at(scene, "arms", "leader", "model") or "")
        arms.append(ArmOfRun(f"psm{k}", leader_name(model, k, [arm.leader for arm in arms]), record, scene))
    return Demonstration(name, path, tuple(arms), tuple(fault for record in records for fault in record.faults))


def _require_whole(record: Record) -> None:
    """Refuse a record that is cut off, or that holds no follower.

    Raises:
        RecordError: as said.
    """
    where = str(record.path)
    if not record.complete:
        what = f"the record is cut off after {record.duration:.2f} s: the end of the demonstration is missing"
        mend = f"palpate record repair {where!r} --out whole.mcap keeps what was written; export that"
        raise RecordError(what, where=where, why="the run was killed, or the disk was full", mend=mend)
    missing = [name for name in NEEDED if name not in record.signals]
    if missing:
        what = f"the record has no follower: it lacks {' and '.join(missing)}"
        mend = "record again, without record.signals in the scene or with these names in it"
        raise RecordError(what, where=where, why="the scene's record.signals left them out", mend=mend)


def _of_bag(path: Path, bag: Bag) -> Demonstration:
    leader, follower = bag.pair
    if follower is None and leader.upper().startswith("PSM"):
        leader, follower = "", leader
    if follower is None:
        what = "the bag has no follower: no PSM with measured_cp or measured_js"
        why = f"its arms: {', '.join(bag.arms)}"
        raise RecordError(what, where=str(path), why=why, mend="record the follower's topics too: ros2 bag record -a")
    ticks = BagTicks(bag, leader, follower)
    arm = ArmOfRun(follower.lower().replace("/", "_"), leader.lower().replace("/", "_"), ticks, _mapping(bag.scene))
    return Demonstration(path.stem, path, (arm,))


def _mapping(text: str) -> Content:
    try:
        data = load(text) if text else {}
    except Exception:  # a scene of another version need not be readable
        data = {}
    return data if isinstance(data, dict) else {}


def _at(data: Any, *place: str | int) -> Any:
    """A value deep in nested dictionaries and lists; None where one is missing."""
    for key in place:
        if isinstance(data, dict):
            data = data.get(key)
        elif isinstance(data, list) and isinstance(key, int) and key < len(data):
            data = data[key]
        else:
            return None
    return data
