"""How the signals of a tick stand in the messages of a record.

Three topics carry the signals, one message a tick each: `/leader` (operator's side), `/follower` (patient's side) and
`/loop`. A message is a ROS 2 structure of `float64` fields with the names of the signals, so its bytes are the doubles
of the tick in a fixed order. ROS allows no capital letters in these names: the signal F_H_L is the field f_h_l.

A signal that stays constant is not in the messages: `/leader/all` and its kin hold every signal, in one message
whenever the layout changes. The text of the message type is the layout: readers need nothing else.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from palpate.record.mcap_file import MESSAGE_HEAD
from palpate.record.messages import nested
from palpate.record.ticks import SIGNALS, Signal

GROUPS: dict[str, tuple[str, ...]] = {
    "leader": ("leader", "torque", "hand"),
    "follower": ("mapping", "follower", "contact", "force", "guidance", "tracking", "pairs", "remote"),
    "loop": ("loop", "stability"),
}
"""Stages whose signals one topic carries, by the topic's name."""
CDR = b"\x00\x01\x00\x00"
"""Head of every message: little-endian CDR."""
HEAD = MESSAGE_HEAD.size + len(CDR)
"""Bytes of a message record before its first number."""
_TYPE = "palpate_msgs/msg/"
_VECTOR, _QUATERNION = "geometry_msgs/Vector3", "geometry_msgs/Quaternion"
_FIELD = re.compile(rf"(float64|uint64|{_VECTOR}|{_QUATERNION})(?:\[(\d{{1,4}})\])? (\w+)(?: *#.*)?")


def group_of(signal: Signal) -> str:
    """The group that carries a signal."""
    return next((name for name, stages in GROUPS.items() if signal.stage in stages), "loop")


def topic(signal: Signal) -> str:
    """Where other tools find a signal: its topic and its name, e.g. ``/follower/F_T_W``; see `field_name`."""
    return f"/{group_of(signal)}/{signal.name}"


def field_name(signal: str) -> str:
    """Name of the field that carries a signal."""
    return signal.lower()


def type_name(group: str, number: int | None) -> str:
    """Name of a message type: of layout `number` (from 1) of a group, or with all signals for None."""
    name = group.capitalize()
    return _TYPE + (f"{name}All" if number is None else name if number == 1 else f"{name}{number}")


def group_of_topic(text: str) -> tuple[str, bool] | None:
    """Group of a topic, and whether its messages hold all signals; None for a topic of something else."""
    name, _, rest = text.removeprefix("/").partition("/")
    return (name, rest == "all") if name in GROUPS and rest in ("", "all") and text.startswith("/") else None


@dataclass(frozen=True)
class Field:
    """One field of a message."""

    name: str
    """Of the signal."""
    kind: str
    """``float64``, ``uint64``, ``geometry_msgs/Vector3`` or ``geometry_msgs/Quaternion``."""
    count: int
    """Number of doubles: the first ones of the signal's elements."""
    place: int
    """Position in the message [doubles]."""

    @property
    def order(self) -> list[int]:
        """Elements of the signal in the message's order: a ROS quaternion is x y z w, a tick's w x y z."""
        return [1, 2, 3, 0] if self.kind == _QUATERNION else list(range(self.count))

    @property
    def text(self) -> str:
        """Type of the field in a message definition."""
        plain = self.count == 1 or self.kind in (_VECTOR, _QUATERNION)
        return self.kind if plain else f"{self.kind}[{self.count}]"


@dataclass(frozen=True)
class Layout:
    """The fields of the messages of one channel."""

    fields: tuple[Field, ...]

    @classmethod
    def of(cls, counts: Mapping[Signal, int]) -> Layout:
        """The layout with the first elements of some signals; a vector or a quaternion is whole."""
        fields: list[Field] = []
        place = 0
        for signal, wanted in counts.items():
            kind = kind_of(signal)
            count = signal.size if kind in (_VECTOR, _QUATERNION) else wanted
            if wanted:
                fields.append(Field(signal.name, kind, count, place))
                place += count
        return cls(tuple(fields))

    @classmethod
    def parse(cls, definition: str, names: Mapping[str, str]) -> Layout | None:
        """The layout of a message definition; None for one that is not of numbers with a name each.

        names: name of the signal by that of its field; the same for a field that is not in it.
        """
        fields: list[Field] = []
        place = 0
        for line in definition.partition("=" * 80)[0].splitlines():
            found = _FIELD.fullmatch(line.strip())
            if found is None:
                return None
            kind, number, name = found.groups()
            size = {_VECTOR: 3, _QUATERNION: 4}.get(kind, int(number or 1))
            fields.append(Field(names.get(name, name), kind, size, place))
            place += size
        return cls(tuple(fields)) if fields else None

    @cached_property
    def by_name(self) -> dict[str, Field]:
        """The fields by the name of their signal."""
        return {field.name: field for field in self.fields}

    @property
    def doubles(self) -> int:
        """Numbers in a message."""
        return sum(field.count for field in self.fields)

    @property
    def message_bytes(self) -> int:
        """Length of a message [bytes]."""
        return len(CDR) + 8 * self.doubles

    def definition(self, signals: Mapping[str, Signal]) -> str:
        """The message definition, with unit, frame and meaning of each signal as a comment."""
        lines = [f"{f.text} {field_name(f.name)}  # {f.name} {_words(signals[f.name])}\n" for f in self.fields]
        inner = (_VECTOR, _QUATERNION)
        return "".join(lines) + nested([k for k in inner if any(f.kind == k for f in self.fields)])

    def elements(self) -> NDArray[np.intp]:
        """Positions in a tick of the message's numbers [doubles], in the message's order."""
        places = [SIGNALS[f.name].offset // 8 + k for f in self.fields for k in f.order]
        return np.array(places, dtype=np.intp)


def kind_of(signal: Signal) -> str:
    """Type of the field that carries a signal."""
    if signal.is_bits:
        return "uint64"
    if signal.size == 4 and signal.name.startswith("quat"):
        return _QUATERNION
    return _VECTOR if signal.size == 3 and signal.frame else "float64"


def whole(signals: Iterable[Signal]) -> Layout:
    """The layout with every element of some signals."""
    return Layout.of({signal: signal.size for signal in signals})


def _words(signal: Signal) -> str:
    unit = "" if signal.unit in ("", "1", "bits") else f"[{signal.unit}] "
    return unit + (f"in {signal.frame}: " if signal.frame else "") + signal.doc


def kept(
    deterministic: bool,
    tracked: bool = True,
    paired: bool = True,
    only: Sequence[str] | None = None,
    linked: bool = True,
) -> dict[str, list[Signal]]:
    """The signals of a record by their group, in the order of the tick.

    Args:
        deterministic: True leaves out signals that depend on the machine, as in a lockstep record.
        tracked: False leaves out the signals of live objects and tracked frames.
        paired: False leaves out the signals of contact with other pairs.
        only: names of the signals to keep; None keeps all. The time is always kept.
        linked: False leaves out the signals of a remote site.
    """
    parts = (("tracking", tracked), ("pairs", paired), ("remote", linked))
    left_out = {stage for stage, is_kept in parts if not is_kept}
    found: dict[str, list[Signal]] = {}
    for signal in SIGNALS.values():
        wanted = only is None or signal.name == "t" or signal.name in only
        if wanted and signal.stage not in left_out and (signal.deterministic or not deterministic):
            found.setdefault(group_of(signal), []).append(signal)
    return found
