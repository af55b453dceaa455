"""The graph of a ROS 2 network: nodes and topics, with the measured rate of each topic and the age of its messages."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from palpate import ros
from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.ros import topic

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from palpate.base.plotting.style import Canvas

SETTLED = 1.5
"""The network is discovered when it has not grown for this time [s]."""
MOST_DISCOVERY = 20.0
"""Longest time for discovery [s]."""
_HIDDEN = ("/rosout", "/parameter_events")
AT_ONCE = 48
"""Number of topics that are listened to at the same time: publishers shall not be slowed down."""
COLLECTED = ("/tf", "/tf_static", "/diagnostics")
"""Topics that ROS 2 collects from many nodes."""
_OWN = "palpate_topic"  # name of the nodes that look
_NONE = np.zeros(0)


@dataclass(frozen=True)
class TopicFacts:
    """A topic with its endpoints and its measured rate."""

    name: str
    type: str
    publishers: list[str]
    """full names of the nodes, sorted"""
    subscribers: list[str]
    messages: int
    rate_hz: float | None  # None: fewer than two messages
    age_p50_ms: float | None  # arrival after the header's stamp; None: no header, or no stamp
    age_max_ms: float | None

    @property
    def measured(self) -> str:
        """Rate and age in words; the number of messages where they are too few for a rate."""
        rate = f"{self.messages} messages" if self.rate_hz is None else f"{self.rate_hz:.1f} Hz"
        return rate if self.age_p50_ms is None else f"{rate}, {self.age_p50_ms:.2f} ms old"


@dataclass(frozen=True)
class NodeFacts:
    """A node with its topics."""

    name: str
    publishes: list[str]
    subscribes: list[str]


@dataclass(frozen=True)
class Graph:
    """Nodes and topics as measured."""

    seconds: float
    nodes: list[NodeFacts]
    topics: list[TopicFacts]
    duplicate_nodes: list[str]
    """names that several nodes have, which ROS 2 does not allow"""
    shared_topics: list[str]
    """topics that several nodes publish, other than those that ROS 2 collects from many nodes"""


def measure(seconds: float = 3.0, network: bool = False, progress: Callable[[int], None] | None = None) -> Graph:
    """Discover the graph and listen to every published topic for `seconds` [s], `AT_ONCE` topics at a time.

    Args:
        seconds: time for each topic [s].
        network: look at other machines too.
        progress: called with the number of topics before listening begins.

    Raises:
        RosMissingError: no ROS 2. PalpateError: there is no other node.
    """
    with topic.node(network) as here:
        names, found = _discovered(here)
        heard = _heard(here, sorted(found), seconds, network, progress or (lambda n: None))
        topics = [_facts(here, name, kind, *heard.get(name, (_NONE, _NONE))) for name, kind in sorted(found.items())]
    topics = [one for one in topics if one.publishers or one.subscribers]
    if not names and not topics:
        raise PalpateError("there is no node on this network", mend="start one, e.g. palpate ros sim; or add --network")
    nodes = [
        NodeFacts(
            name,
            [one.name for one in topics if name in one.publishers],
            [one.name for one in topics if name in one.subscribers],
        )
        for name in sorted(set(names))
    ]
    twice = sorted(name for name, n in Counter(names).items() if n > 1)
    return Graph(seconds, nodes, topics, twice, [one.name for one in topics if is_shared(one)])


def is_shared(topic: TopicFacts) -> bool:
    """True if several nodes publish the topic. A haptic node and its guardian, which takes over from it, count as one.

    Their names are palpate_writer_MARK and palpate_guardian_MARK.
    """
    names = {name.replace("palpate_guardian_", "palpate_writer_") for name in topic.publishers}
    return len(names) > 1 and topic.name not in COLLECTED


def _discovered(here: Any) -> tuple[list[str], dict[str, str]]:
    """Full names of the nodes, and the type of each topic, once the network does not grow any more."""
    begin = grown = time.monotonic()
    names: list[str] = []
    found: dict[str, str] = {}
    while (now := time.monotonic()) - grown < SETTLED and now - begin < MOST_DISCOVERY:
        size = len(names) + len(found)
        topic.spin(here, 0.1)
        names = [f"{space.rstrip('/')}/{name}" for name, space in here.get_node_names_and_namespaces() if name != _OWN]
        found = {name: types[0] for name, types in here.get_topic_names_and_types() if name not in _HIDDEN}
        grown = now if len(names) + len(found) != size else grown
    return names, found


def _heard(
    here: Any, names: list[str], seconds: float, network: bool, progress: Callable[[int], None]
) -> dict[str, tuple[Array, Array]]:
    """Monotonic times of the messages of each published topic (n,) [s], and their ages (m,) [s]."""
    native = ros.load()
    meter = native.TopicMeter(native.Context(network=network), _OWN)
    wanted = {name: row for name in names if (row := _wanted(here, name)) is not None}
    progress(len(wanted))
    heard: dict[str, tuple[Array, Array]] = {}
    for k in range(0, len(wanted), AT_ONCE):
        some = list(wanted)[k : k + AT_ONCE]
        meter.listen([wanted[name] for name in some])
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            topic.spin(here, min(left, 0.1))
        heard |= dict(zip(some, meter.take(), strict=True))
    return heard


def _wanted(here: Any, name: str) -> tuple[str, Any, bool, bool] | None:
    """A topic for the meter; None if nobody publishes it or its type is not known here."""
    from rclpy.qos import DurabilityPolicy
    from rclpy.type_support import check_for_type_support

    if not here.get_publishers_info_by_topic(name):
        return None
    try:
        kind, quality = topic.publisher_type(here, name)
    except PalpateError:
        return None
    check_for_type_support(kind)
    first = next(iter(kind.get_fields_and_field_types().values()), "")
    latched = quality.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return name, kind.__class__._TYPE_SUPPORT, first == "std_msgs/Header", latched


def _facts(here: Any, name: str, kind: str, arrivals: Array, ages: Array) -> TopicFacts:
    def nodes(ends: Any) -> list[str]:
        full = {f"{end.node_namespace.rstrip('/')}/{end.node_name}" for end in ends if end.node_name != _OWN}
        return sorted(full)

    span = float(arrivals[-1] - arrivals[0]) if len(arrivals) > 1 else 0.0
    return TopicFacts(
        name,
        kind,
        nodes(here.get_publishers_info_by_topic(name)),
        nodes(here.get_subscriptions_info_by_topic(name)),
        len(arrivals),
        (len(arrivals) - 1) / span if span > 0.0 else None,
        1e3 * float(np.median(ages)) if len(ages) else None,
        1e3 * float(ages.max()) if len(ages) else None,
    )


def draw(graph: Graph, path: Path) -> int:
    """Draw publishers, topics with their rates and ages, and subscribers; returns the number of topics drawn.

    Topics that connect two nodes, or else those with messages, are drawn.
    """
    from palpate.base.plotting.style import png

    shown = [one for one in graph.topics if one.publishers and one.subscribers]
    shown = shown or [one for one in graph.topics if one.messages]
    shown = shown[:60]
    png(partial(_drawing, shown), path)
    return len(shown)


def _drawing(shown: list[TopicFacts], canvas: Canvas) -> Figure:
    from matplotlib.figure import Figure as NewFigure

    from palpate.base.plotting.style import JOINTS

    left = list(dict.fromkeys(node for one in shown for node in one.publishers))
    right = list(dict.fromkeys(node for one in shown for node in one.subscribers))
    height = max(2.0, 0.24 * max(len(shown), len(left), len(right)) + 0.6)
    figure = NewFigure(figsize=(10.0, height), layout="constrained")
    axes = figure.subplots()
    axes.axis("off")
    place = {key: dict(zip(names, _spread(len(names)), strict=True)) for key, names in (("l", left), ("r", right))}
    for k, (one, y) in enumerate(zip(shown, _spread(len(shown)), strict=True)):
        color = JOINTS[k % len(JOINTS)]
        for node in one.publishers:
            axes.plot([0.0, 0.8], [place["l"][node], y], color=color, lw=0.8)
        for node in one.subscribers:
            axes.plot([2.2, 3.0], [y, place["r"][node]], color=color, lw=0.8)
        axes.text(1.5, y, f"{one.name}   {one.measured}", ha="center", va="center", fontsize=7)
    for x, key, side in ((0.0, "l", "right"), (3.0, "r", "left")):
        for node, y in place[key].items():
            axes.text(x, y, f" {node} ", ha=side, va="center", fontsize=7.5, weight="bold")
    axes.set_xlim(-1.1, 4.1)
    axes.set_ylim(-0.05, 1.05)
    return figure


def _spread(n: int) -> list[float]:
    """Heights of n entries from top to bottom."""
    return [0.5] if n == 1 else np.linspace(1.0, 0.0, n).tolist()
