"""Reads tracks and events from a rosbag2; `_MOTION` maps topics to tracks, and the library rosbags decodes messages."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from palpate.record.bags.library import open_bag
from palpate.record.bags.stamps import offset_words
from palpate.record.bags.tracks import ArmTracks, Contents, Event, Topic, Track

_MOTION = {
    "measured_js": "js",
    "measured_cp": "pose",
    "measured_cv": "twist",
    "setpoint_cp": "goal",
    "servo_cp": "goal",
    "servo_cs": "goal",
    "body/servo_cf": "wrench",
    "spatial/servo_cf": "wrench",
    "following/mtm/body/servo_cf": "wrench",
    "gripper/measured_js": "gripper",
    "jaw/measured_js": "gripper",
    "body/set_cf_orientation_absolute": "absolute",
}
"""End of a topic's name, after the name of the arm -> the quantity it carries."""
_EVENTS = (
    "operating_state", "current_state", "following", "operator_present", "clutch", "camera", "status", "warning",
    "error", "state_command", "goal_reached", "enabled", "pinch", "closed", "message",
)  # fmt: skip
"""Last components of topics whose messages become events."""
_SCENE = "scene"


def read(path: Path) -> Contents:
    """Decode a bag; raises the errors of `Bag.open`."""
    if path.is_dir() and not (path / "metadata.yaml").exists() and len(only := sorted(path.glob("*.mcap"))) == 1:
        path = only[0]  # a killed recorder leaves no metadata
    with open_bag(path) as reader:
        return _Reading(path, reader).bag()


class _Reading:
    """State of one pass over a bag."""

    def __init__(self, path: Path, reader: Any) -> None:
        self.path, self.reader, self.begin = path, reader, int(reader.start_time)
        self.rows: dict[tuple[str, str], list[tuple[float, float, list[float]]]] = defaultdict(list)
        self.events: list[Event] = []
        self.times: dict[str, list[float]] = defaultdict(list)
        self.stamps: dict[str, list[float]] = defaultdict(list)
        self.silent: dict[str, int] = defaultdict(int)
        self.bad: dict[str, int] = defaultdict(int)
        self.undecoded: dict[str, str] = {}
        self.frames: dict[str, float] = defaultdict(float)
        self.scene = ""

    def bag(self) -> Contents:
        for connection, time, data in self.reader.messages():
            topic, t = connection.topic, 1e-9 * (time - self.begin)
            self.times[topic].append(t)
            try:
                message = self.reader.deserialize(data, connection.msgtype)
            except Exception as error:
                self.undecoded.setdefault(topic, f"{connection.msgtype}: {type(error).__name__}")
                continue
            self._take(topic, t, message)
        arms = {name: self._arm(name) for name in dict.fromkeys(n for n, _ in self.rows)}
        duration = max((t[-1] for t in self.times.values()), default=0.0)
        notes = [*self.reader.notes]
        notes += [f"{topic} could not be decoded ({why})" for topic, why in self.undecoded.items()]
        for kind, why in self.reader.undecodable.items():
            names = ", ".join(sorted({c.topic for c in self.reader.connections if c.msgtype == kind}))
            notes.append(f"the definition of {kind} in the bag cannot be read ({why}); it is the type of {names}")
        notes += [words for topic in sorted(self.stamps) if (words := offset_words(topic, self._offset(topic)))]
        return Contents(
            self.path, duration, arms, self.events, list(self._topics()), self.scene, notes, 1e-9 * self.begin
        )

    def _take(self, topic: str, t: float, message: Any) -> None:
        stamp = getattr(getattr(message, "header", None), "stamp", None)
        valid = stamp is None or stamp.sec or stamp.nanosec
        self.silent[topic] += not valid
        s = math.nan if stamp is None or not valid else 1e-9 * (stamp.sec * 10**9 + stamp.nanosec - self.begin)
        if math.isfinite(s):
            self.stamps[topic].append(s - t)
        name, quantity = _arm_and_quantity(topic)
        if quantity == "absolute":
            self.frames[name] = float(message.data)
        elif quantity is not None:
            self._move(topic, name, quantity, (t, s), message, bool(valid))
        elif topic.rsplit("/", 1)[-1] == _SCENE and hasattr(message, "data"):
            self.scene = str(message.data)
        elif topic.rsplit("/", 1)[-1] in _EVENTS and (text := _words(message)):
            self.events.append(Event(t, topic, text))

    def _move(self, topic: str, name: str, quantity: str, at: tuple[float, float], message: Any, valid: bool) -> None:
        found = dict(_numbers(quantity, message))
        if not all(np.isfinite(v).all() for v in found.values()):
            self.bad[topic] += 1
        elif valid or quantity == "wrench":  # a zero stamp invalidates a measurement, but not a commanded wrench
            for field, values in found.items():
                self.rows[name, field].append((*at, values))
            if quantity == "wrench":
                frame = 1.0 if topic.endswith("spatial/servo_cf") else self.frames[name]
                self.rows[name, "absolute"].append((*at, [frame]))

    def _arm(self, name: str) -> ArmTracks:
        arm = ArmTracks(name)
        for field in ("q", "v", "tau", "pose", "twist", "goal", "wrench", "absolute", "gripper"):
            rows = self.rows.get((name, field), [])
            width = max((len(v) for *_, v in rows), default=0)
            rows = [r for r in rows if len(r[2]) == width and width]
            if rows:
                t, stamps, values = (np.array(column) for column in zip(*rows, strict=True))
                setattr(arm, field, Track(t, values, stamps))
        return arm

    def _topics(self) -> Iterator[Topic]:
        types = {c.topic: c.msgtype for c in self.reader.connections}
        for name in sorted(types):
            steps = np.diff(self.times[name])
            rate = 1.0 / float(np.median(steps)) if len(steps) > 1 and np.median(steps) > 0 else 0.0
            gap = float(steps.max()) if len(steps) else 0.0
            count, offset = len(self.times[name]), self._offset(name)
            yield Topic(name, types[name], count, rate, gap, self.silent[name], self.bad[name], offset)

    def _offset(self, topic: str) -> float | None:
        """Median of stamp minus time of reception [s]; None without stamps."""
        return float(np.median(self.stamps[topic])) if self.stamps[topic] else None


def _arm_and_quantity(topic: str) -> tuple[str, str | None]:
    """Arm and quantity of a topic, e.g. ``("MTMR", "pose")``; ``("", None)`` for other topics."""
    parts = topic.strip("/").split("/")
    for k in range(1, len(parts)):
        ending = "/".join(parts[k:])
        if ending in _MOTION:
            name = "/".join(parts[:k])
            if ending.startswith("following/"):
                name = re.sub(r"_[^_/]+$", "", name)  # MTMR_PSM1 commands MTMR
            return name, _MOTION[ending]
    return "", None


def _numbers(quantity: str, message: Any) -> Iterator[tuple[str, list[float]]]:
    """Fields of `ArmTracks` that a message fills, with their values."""
    if quantity in ("js", "gripper"):
        fields = {"q": "position", "v": "velocity", "tau": "effort"} if quantity == "js" else {"gripper": "position"}
        for field, array in fields.items():
            if len(getattr(message, array)):
                yield field, [float(x) for x in getattr(message, array)]
    elif quantity in ("pose", "goal"):
        inner = getattr(message, "pose", None) or getattr(message, "transform", None) or message
        p, q = getattr(inner, "position", None) or inner.translation, getattr(inner, "orientation", None)
        q = q if q is not None else inner.rotation  # TransformStamped: dVRK before 2.2
        yield quantity, [p.x, p.y, p.z, q.w, q.x, q.y, q.z]
    else:
        inner = getattr(message, quantity)
        a, b = (inner.force, inner.torque) if quantity == "wrench" else (inner.linear, inner.angular)
        yield quantity, [a.x, a.y, a.z, b.x, b.y, b.z]


def _words(message: Any) -> str:
    """Text of a message; empty for other message types."""
    texts: dict[str, Callable[[Any], str]] = {
        "state": lambda m: f"{m.state}{', homed' if m.is_homed else ''}{', busy' if m.is_busy else ''}",
        "string": lambda m: str(m.string),
        "buttons": lambda m: {0: "released", 1: "pressed", 2: "tapped"}.get(int(m.buttons[0]), str(m.buttons[0])),
        "data": lambda m: str(m.data),
    }
    for field, text in texts.items():
        if hasattr(message, field):
            try:
                return text(message)
            except (AttributeError, IndexError):
                return ""
    return ""
