"""All examinations by topic. A new topic is one line here and a function that returns findings."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from palpate.base.errors import PalpateError
from palpate.cli.doctor import connected, machine, programs
from palpate.cli.doctor.finding import Finding

TOPICS: dict[str, Callable[[], list[Finding]]] = {
    "versions": machine.versions,
    "compiler": programs.compiler,
    "real-time": machine.real_time,
    "processor": machine.processor,
    "disk": machine.disk,
    "extras": programs.extras,
    "browser": programs.browser,
    "ROS 2": programs.ros,
    "USB": connected.usb,
    "inputs": connected.inputs,
    "devices": connected.devices,
    "ports": connected.ports,
}


def examine(topics: Sequence[str] = ()) -> list[Finding]:
    """Examine the machine. Nothing is changed, and no device is opened.

    Args:
        topics: keys of TOPICS; none: all.

    Raises:
        PalpateError: there is no such topic.
    """
    for topic in topics:
        if topic not in TOPICS:
            raise PalpateError(f"there is no topic {topic!r}", mend=f"name some of: {', '.join(TOPICS)}")
    return [finding for topic, look in TOPICS.items() if not topics or topic in topics for finding in look()]
