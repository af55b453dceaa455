"""`palpate bench ros`: latency over ROS 2 from a leader's state to the wrench that answers it.

Two processes run on this machine: a leader that publishes its states (this process, in C++), and the haptic node with a
virtual wall. A third process echoes wrenches that are sent half a period after each state; its round trip measures the
latency of ROS 2 itself in the same run.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypedDict

import numpy as np
from rich.table import Table

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.scene import shipped
from palpate_lab.verify.processes import end as end_process

Figures = dict[str, float | str]
"""By the keys of `palpate bench ros` in docs/json.md."""


class Counted(TypedDict):
    """Counts and timing of the node's process."""

    published: int
    cycle_us: dict[str, float]
    cpu_s: float
    scheduler: str


LEADER, TELEOP = "palpate_bench", "palpate_bench_wall"
RATE, SECONDS = 1000.0, 20.0
SETTLE = 0.7  # settling time before the measurement [s]
_CROSSING = 10e-6  # minimum transport time; a wrench stamped sooner after a state cannot be its answer [s]
_START = 120.0  # timeout for the start of the other processes [s]
_ECHO = """
import sys, palpate.ros
ros = palpate.ros.load()
echo = ros.Echo(ros.Context(), "/palpate_there", "/palpate_back")
print("ready", flush=True)
sys.stdin.read()
"""
_WALL = np.array([0.0, -0.0225, 0.0])  # displacement in scenes/wall.yaml from the start to 2 mm inside the wall [m]


def run(seconds: float = SECONDS, rate: float = RATE, on_progress: Callable[[str], None] = lambda _: None) -> Figures:
    """Measure; the result has the keys of `palpate bench ros` in docs/json.md.

    Raises:
        RosMissingError: ROS 2 is not installed.
        PalpateError: the node does not start, or never renders a force.
    """
    from palpate import ros

    native = ros.load(on_progress)
    options = native.MockLeaderOptions()
    options.leader, options.teleop, options.rate, options.echo = LEADER, TELEOP, rate, True
    options.wrench = f"/{TELEOP}/following/mtm/body/servo_cf"
    mock_leader = native.MockLeader(native.Context(), options)
    node_command = ["-m", "palpate_lab.verify.bench.ros_node", str(shipped.file("wall")), f"{rate:g}", LEADER, TELEOP]
    with _process("-c", _ECHO), _process(*node_command) as node:
        on_progress("node and echo are up")
        mock_leader.start()
        mock_leader.set_state("ENABLED")
        mock_leader.follow(True)
        _await(lambda: len(mock_leader.wrenches) > 10, "the node sends no wrench")
        time.sleep(SETTLE)
        _touch(mock_leader)
        mock_leader.swing(np.array([0.0, 0.0005, 0.0]), 1.0)
        time.sleep(SETTLE)
        begin, before = time.monotonic(), (int(mock_leader.pings), len(mock_leader.echoes))
        for left in np.arange(seconds, 0.0, -5.0):
            on_progress(f"{left:.0f} s to go")
            time.sleep(min(5.0, left))
        end = time.monotonic()
        pushed = float(np.linalg.norm(mock_leader.wrenches[-1, 3:6]))
        counted = _ended(node)
        mock_leader.stop()
        time.sleep(0.2)  # for the last echoes
    return _figures(mock_leader, counted, begin, end, rate, before) | {"force_N": pushed}


def answers(sent: Array, felt: Array, wall_minus_monotonic: float) -> tuple[Array, int]:
    """Time from each state to its wrench, and the number of states without a wrench before the next state.

    Args:
        sent: publication times of the states (n,) [s, monotonic].
        felt: received wrenches (m, 10), as recorded by the mock_leader.
        wall_minus_monotonic: offset between the clock of the stamps and the monotonic clock [s].

    Returns:
        Latencies (k,) [s], and the number of states without an own answer.
    """
    stamps = felt[:, 2] - wall_minus_monotonic
    state = np.searchsorted(sent, stamps - _CROSSING, side="right") - 1  # newest state that the node can have received
    good = state >= 0
    first, index = np.unique(state[good], return_index=True)  # only the first answer to a state counts
    took = felt[good, 0][index] - sent[first]
    return took, len(sent) - len(first)


def table(result: Figures) -> Table:
    """The result as a table for a terminal."""
    out = Table(title=f"leader's state to wrench, {result['rate_hz']:g} Hz, {result['seconds']:.0f} s",
                title_justify="left", box=None, padding=(0, 2, 0, 0))  # fmt: skip
    for column in ("", "p50", "p99", "p99.9", "longest"):
        out.add_column(column, justify="right" if column else "left")
    for key, words in (("latency", "state to wrench"), ("echo", "bare echo, there and back")):
        values = [f"{result[f'{key}_{p}_us']:.0f} us" for p in ("p50", "p99", "p999", "max")]
        out.add_row(words, *values)
    out.caption_justify = "left"
    out.caption = (
        f"{result['states']} states, {result['commands']} commands, {result['lost']} lost, {result['late']} states "
        f"without an answer before the next;\nnode {result['node_cores']:.2f} cores; {result['scheduler']}"
    )
    return out


def of_sim(
    seconds: float = 10.0, arms: tuple[str, ...] = ("MTMR", "MTML", "PSM1", "PSM2"), rate: float = RATE
) -> dict[str, float]:
    """CPU load and achieved rate of `palpate ros sim` with these powered and homed arms at `rate` [Hz].

    Returns:
        `sim_cores`: mean number of cores that the process uses [-]; `sim_rate_hz`: rate of the slowest arm's
        measurements [Hz].

    Raises:
        PalpateError: the simulation does not start.
    """
    from palpate import ros
    from palpate.ros import topic

    command = [sys.executable, "-m", "palpate", "ros", "sim", "--rate", f"{rate:g}", "--arms", *arms]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            with topic.node() as here:
                _await(lambda: ("/system/home", "std_msgs/msg/Empty") in topic.topics(here, 0.2), "no simulated robot")
                for verb in ("power_on", "home"):
                    topic.publish(here, f"/system/{verb}", "std_msgs/msg/Empty", "{}", None)
                    time.sleep(4.0)
            native = ros.load()
            context = native.Context()
            subscribers = [native.Echo(context, f"/{arm}/body/measured_cf", f"/palpate_heard/{arm}") for arm in arms]
            _await(lambda: all(s.count for s in subscribers), "an arm of the simulated robot publishes nothing")
            before, counts, start = _cpu_time(process.pid), [s.count for s in subscribers], time.monotonic()
            time.sleep(seconds)
            if process.poll() is not None:
                raise PalpateError("palpate ros sim ended by itself", mend="run it alone to see why")
            took = time.monotonic() - start
            slowest = min(s.count - count for s, count in zip(subscribers, counts, strict=True))
            return {"sim_cores": (_cpu_time(process.pid) - before) / took, "sim_rate_hz": slowest / took}
        finally:
            process.terminate()


def _figures(
    mock_leader: Any, counted: Counted, begin: float, end: float, rate: float, before: tuple[int, int]
) -> Figures:
    """Figures of the measured interval; before: numbers of pings and echoes at its start."""
    sent, felt, echoes = mock_leader.sent[:, 0], mock_leader.wrenches, mock_leader.echoes[before[1] :, 0]
    felt = felt[felt[:, 9] == np.bincount(felt[:, 9].astype(int)).argmax()]  # wrenches of the node, not its guardian
    wall = float(np.median(felt[:, 1] - felt[:, 0]))
    inside = (sent >= begin) & (sent < end)
    took, late = answers(sent[inside], felt[(felt[:, 0] >= begin) & (felt[:, 0] < end + 1.0 / rate)], wall)
    figures: Figures = {
        "rate_hz": rate,
        "seconds": end - begin,
        "states": int(inside.sum()),
        "commands": counted["published"],
        "lost": int(counted["published"]) - len(felt),
        "late": late,
        "echoes": len(echoes),
        "echo_lost": int(mock_leader.pings) - before[0] - len(echoes),
    }
    for key, values in (("latency", took), ("echo", echoes)):
        points = np.percentile(1e6 * values, [50, 99, 99.9, 100]).tolist() if len(values) else [float("nan")] * 4
        figures |= {f"{key}_{p}_us": v for p, v in zip(("p50", "p99", "p999", "max"), points, strict=True)}
    figures["cycle_p50_us"], figures["cycle_p99_us"] = counted["cycle_us"]["p50"], counted["cycle_us"]["p99"]
    figures["node_cores"] = counted["cpu_s"] / max(len(sent) / rate, 1e-9)
    figures["leader_late_p99_us"], figures["scheduler"] = mock_leader.late_p99_us, counted["scheduler"]
    return figures


@contextmanager
def _process(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A Python process that has printed `ready`; it is terminated at the end of the context."""
    command = [sys.executable, *arguments]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout
        if process.stdout.readline() != "ready\n":
            raise PalpateError(f"{' '.join(arguments[:2])} does not start", mend="see its output above")
        yield process
    finally:
        end_process(process)


def _touch(mock_leader: Any) -> None:
    """Move the leader until the wall renders a force; repeat if the node started to follow after the motion."""
    for turn in range(1, 6):
        mock_leader.move_to(turn * _WALL, 0.5)
        end = time.monotonic() + 2.0
        while time.monotonic() < end:
            if np.abs(mock_leader.wrenches[-1, 3:6]).max() > 0.1:
                return
            time.sleep(0.02)
    mend = "run palpate ros haptics scenes/wall.yaml, which reports what prevents a force"
    raise PalpateError("the wall renders no force", mend=mend)


def _ended(node: subprocess.Popen[str]) -> Counted:
    """Ask the node to end and return its counts."""
    out, _ = node.communicate(timeout=30.0)
    counted: Counted = json.loads(out.splitlines()[-1])
    return counted


def _await(true: Callable[[], bool], otherwise: str) -> None:
    end = time.monotonic() + _START
    while not true():
        if time.monotonic() > end:
            raise PalpateError(otherwise, why=f"waited {_START:g} s", mend="palpate ros setup")
        time.sleep(0.02)


def _cpu_time(pid: int) -> float:
    """User and system time of a process [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / float(os.sysconf("SC_CLK_TCK"))
