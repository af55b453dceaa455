"""`palpate bench ros --faults`: how soon after a fault the hand is free, with real processes over ROS 2.

A mock leader presses against a virtual wall that `palpate ros haptics` renders. Each fault is planted many times; the
time counts from the moment when the fault can be detected (a silence, for instance, after `stale_after`) to the first
zero wrench after which no force follows. The worst try is reported beside the median, and nothing is left out.
"""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from palpate_lab.verify.bench.ros_stand import MOST, STALE, Node, Stand

Figures = dict[str, Any]
"""By the keys of `palpate bench ros --faults` in docs/json/ros.md."""
RATE, TRIES = 1000.0, 20
GUARDIAN = 0.05  # time after which the node holds a silent guardian for stopped [s]


@dataclass(frozen=True)
class MessageFault:
    """A fault of the leader's messages: fields of `MessageFaults`, when it can be detected [s], and the report."""

    fields: dict[str, object]
    detectable: float
    report: str


MESSAGES = {
    "silence": MessageFault({"silent": True}, STALE, "the leader is silent"),
    "not a number": MessageFault({"not_finite": True}, 0.0, "a number was not finite"),
    "no rotation": MessageFault({"no_rotation": True}, 0.0, "a quaternion was zero"),
    "stamps of zero": MessageFault({"zero_stamp": True}, 0.0, "a stamp was 0"),
    "clock ahead": MessageFault({"clock": 1.0}, 0.0, "ahead"),
    "clock behind": MessageFault({"clock": -1.0}, 0.0, "behind"),
    "delay of 100 ms": MessageFault({"delay": 0.1}, STALE, "the leader is silent"),
}


def run(tries: int = TRIES, rate: float = RATE, on_progress: Callable[[str], None] = lambda _: None) -> Figures:
    """Measure; the result has the keys of `palpate bench ros --faults`.

    Args:
        tries: how often each fault is planted [-].
        rate: of the leader's states and of the haptic cycle [Hz].
        on_progress: called with a line on each step.

    Raises:
        RosMissingError: ROS 2 is not installed.
        PalpateError: the node does not start, or renders no force before a fault.
    """
    from palpate import ros

    rows, begin = [], time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        stand = Stand(ros.load(on_progress), f"palpate_faults_{os.getpid()}", rate)
        node = Node(stand, Path(folder), "--bare")
        try:
            stand.press(60.0)
            for name, act in _faults(stand, node).items():
                took = [_freed(stand, act) for _ in range(tries)]
                rows.append(row(name, took, stand.steepest(begin)))
                on_progress(f"{name}: {1e3 * rows[-1]['median_s']:.1f} ms, worst {1e3 * rows[-1]['worst_s']:.1f} ms")
        finally:
            node.process.send_signal(signal.SIGCONT)
            node.process.kill()
            node.process.wait()
    return {"rate_hz": rate, "tries": tries, "asked_s": MOST, "load": os.getloadavg()[0], "faults": rows}


def table(result: Figures) -> Table:
    """The result as a table for a terminal."""
    title = f"from a fault that can be detected to a free hand, {result['rate_hz']:g} Hz, {result['tries']} tries each"
    out = Table(title=title, title_justify="left", box=None, padding=(0, 2, 0, 0))
    for column in ("", "median", "worst", f"later than {1e3 * result['asked_s']:g} ms"):
        out.add_column(column, justify="right" if column else "left")
    for row in result["faults"]:
        out.add_row(row["fault"], *(f"{1e3 * row[key]:.1f} ms" for key in ("median_s", "worst_s")), str(row["late"]))
    out.caption_justify = "left"
    steepest = max(row["steepest_N_s"] for row in result["faults"])
    out.caption = f"fastest growth of the force when it returns {steepest:.1f} N/s; load {result['load']:.1f}"
    return out


def _faults(stand: Stand, node: Node) -> dict[str, Callable[[], float]]:
    """What plants each fault and returns the time to a free hand [s]; `Stand.press` ends all but stopped processes."""

    def messages(fault: MessageFault) -> Callable[[], float]:
        return lambda: stand.released(stand.inject(**fault.fields) + fault.detectable)

    def stopped(pid: int, freed: Callable[[float], float]) -> Callable[[], float]:
        def act() -> float:
            begin = time.monotonic()
            os.kill(pid, signal.SIGSTOP)
            try:
                return freed(begin)
            finally:
                os.kill(pid, signal.SIGCONT)

        return act

    def changed(act: Callable[[], None]) -> Callable[[], float]:
        def fault() -> float:
            begin = time.monotonic()
            act()
            return stand.released(begin)

        return fault

    return {name: messages(fault) for name, fault in MESSAGES.items()} | {
        "arm in FAULT": changed(lambda: stand.mock_leader.set_state("FAULT")),
        "pedal released": changed(lambda: stand.mock_leader.follow(False)),
        "node stopped": stopped(node.process.pid, stand.released),
        "guardian stopped": stopped(node.guardian, lambda begin: stand.released(begin + GUARDIAN)),
    }


def _freed(stand: Stand, act: Callable[[], float]) -> float:
    stand.press()
    return act()


def row(name: str, took: list[float], steepest: float) -> dict[str, Any]:
    """A row of the result, from the times to a free hand [s] and the fastest growth of the force [N/s]."""
    late = int(np.sum(np.array(took) > MOST))
    return {"fault": name, "median_s": float(np.median(took)), "worst_s": max(took), "late": late,
            "steepest_N_s": steepest}  # fmt: skip
