"""A test stand for the haptic node: a mock leader in this process, and `palpate ros haptics` in its own process.

An arm has no timeout, so the last received wrench stays active (`Stand.held`). Times are monotonic [s].
"""

from __future__ import annotations

import json
import os
import queue
import resource
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PalpateError

RATE = 250.0
"""Rate of the leader's states and of the haptic cycle where nothing else is said [Hz]."""
STALE = 0.03
MOST = 0.05
"""Longest time from the detectability of a fault to zero force [s]."""
RATE_CAP = 50.0
"""Fastest growth of the force [N/s]."""


def scene(rate: float = RATE) -> str:
    """Text of the scene that the node renders: a wall of 300 N/m in front of the hand, at a cycle of `rate` [Hz]."""
    return f"""
objects:
  - {{name: wall, plane: {{size: 0.12}}, pose: {{xyz: [0, -0.387, -0.1288], rpy_deg: [-90, 0, 0]}}, stiffness: 300,
     damping: 2}}
arms: {{leader: {{base: {{xyz: [0, 0, 0]}}, start: [0, 0, 0, 0, 0, 0, 0]}}, follower: {{bandwidth: 0}}}}
mapping: {{scale: 1.0, align_rate: 0}}
rates: {{haptic: {rate:g}}}
stability: {{rate_cap: {RATE_CAP:g}, force_cap: 3}}
operator: {{path: [{{t: 0.2, xyz: [0, -0.380, -0.1288]}}, {{t: 1.0, xyz: [0, -0.381, -0.1288]}}]}}
record: {{report: false}}
"""


class OutputLines:
    """Collects the lines that a process prints."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.lines: list[str] = []
        self._new: queue.Queue[str] = queue.Queue()
        for pipe in (process.stdout, process.stderr):
            threading.Thread(target=self._read, args=(pipe,), daemon=True).start()

    def _read(self, pipe: Any) -> None:
        for line in pipe:
            self.lines.append(line.rstrip())

    def await_line(self, text: str, seconds: float = 30.0, after: int = 0) -> str:
        """Wait for a line with this text after the first `after` lines, and return it."""
        end = time.monotonic() + seconds
        while not (found := [line for line in self.lines[after:] if text in line]):
            _in_time(end, f"no {text!r} within {seconds:g} s: {self.lines[after:]}")
            time.sleep(0.01)
        return found[0]


class Node:
    """A process of `palpate ros haptics` with the leader of the stand.

    Args:
        stand: the mock leader.
        folder: for the scene and everything that the node writes.
        options: further options of the command.
        text: scene; default: `scene` at the stand's rate.
        most_bytes: largest size of a file that the process may write, as on a disk that is full then.
    """

    def __init__(
        self, stand: Stand, folder: Path, *options: object, text: str | None = None, most_bytes: int | None = None
    ) -> None:
        def limit() -> None:
            if most_bytes is not None:
                resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

        file = folder / "wall.yaml"
        file.write_text(text or scene(stand.rate))
        self.json, self.out = folder / "summary.json", folder / "runs"
        command: list[object] = ["-m", "palpate", "ros", "haptics", file, "--leader", stand.leader]
        command += ["--follower", "virtual", "--teleop", stand.teleop, "--out", self.out, "--json", self.json]
        command += ["--force-cap", 1.0, *options]
        self.process = subprocess.Popen(
            [sys.executable, *map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            preexec_fn=None if most_bytes is None else limit,
        )  # fmt: skip
        self.output = OutputLines(self.process)

    @property
    def guardian(self) -> int:
        """Process id of the guardian."""
        return int(self.output.await_line("guardian").rsplit(" ", 1)[1])

    def end(self, signal_number: int = signal.SIGINT) -> dict[str, Any]:
        """End the process by a signal; returns its summary."""
        if self.process.poll() is None:
            self.process.send_signal(signal_number)
            self.process.wait(30)
        summary: dict[str, Any] = json.loads(self.json.read_text())
        return summary


class Stand:
    """The mock leader and measurements of its received wrenches.

    Args:
        native: the compiled module (`palpate.ros.load()`).
        name: of the leader; its teleoperation is `NAME_TELE`.
        rate: of its states [Hz].
        network: also use network interfaces other than the local one.
        options: fields of `MockLeaderOptions`.
    """

    def __init__(self, native: Any, name: str, rate: float = RATE, network: bool = False, **options: object) -> None:
        self.native, self.leader, self.teleop, self.rate = native, name, f"{name}_TELE", rate
        o = native.MockLeaderOptions()
        o.leader, o.teleop, o.rate = self.leader, self.teleop, rate
        o.wrench = f"/{self.teleop}/following/mtm/body/servo_cf"
        for key, value in options.items():
            setattr(o, key, value)
        self.wrench: str = o.wrench
        self.mock_leader = native.MockLeader(native.Context(network=network), o)
        self.mock_leader.set_state("ENABLED")
        self.mock_leader.follow(True)
        self.y = 0.0
        self.mock_leader.start()

    def inject(self, **faults: object) -> float:
        """Inject faults from now on, or none; returns the time [s]."""
        s = self.native.MessageFaults()
        for key, value in faults.items():
            setattr(s, key, value)
        t = time.monotonic()
        self.mock_leader.inject(s)
        return t

    def press(self, seconds: float = 20.0) -> None:
        """End all faults and move towards the wall until the force is about 0.5 N."""
        self.inject()
        self.mock_leader.set_state("ENABLED")
        self.mock_leader.follow(True)
        end = time.monotonic() + seconds
        while not 0.4 < self.force() < 0.8 or self.wrenches_since(time.monotonic() - 0.1) < 5:
            _in_time(end, f"no force of the wall: {self.force():.3f} N")
            if self.wrenches_since(time.monotonic() - 0.1) > 5:
                self.y = float(np.clip(self.y + (0.0004 if self.force() >= 0.8 else -0.0004), -0.2, 0.2))
                self.mock_leader.move_to(np.array([0.0, self.y, 0.0]), 0.015)
            time.sleep(0.02)
        while len(last := self._last_forces()) < 20 or last.min() < 0.3 or np.ptp(last) > 0.02:
            _in_time(end, f"the push does not last: {last} N")
            time.sleep(0.02)
        time.sleep(0.15)

    def _last_forces(self) -> Array:
        """The forces of the last 0.3 s [N]; they differ while the hand still moves, on a busy machine."""
        felt = self.mock_leader.wrenches
        return np.asarray(np.linalg.norm(felt[felt[:, 0] > time.monotonic() - 0.3, 3:6], axis=1))

    def force(self) -> float:
        """Present force on the hand [N]."""
        felt = self.mock_leader.wrenches
        return float(np.linalg.norm(felt[-1, 3:6])) if len(felt) else 0.0

    def wrenches_since(self, t: float) -> int:
        """Number of wrenches that were received since a time [s]."""
        return int((self.mock_leader.wrenches[:, 0] >= t).sum())

    def held(self, begin: float, end: float = np.inf) -> tuple[Array, Array]:
        """(times [s], forces [N]) of the wrenches in an interval; the first entry is the wrench active at its begin."""
        felt = self.mock_leader.wrenches
        forces = np.linalg.norm(felt[:, 3:6], axis=1)
        inside = (felt[:, 0] >= begin) & (felt[:, 0] <= end)
        before = forces[felt[:, 0] < begin]
        start = before[-1] if len(before) else 0.0
        return np.concatenate([[begin], felt[inside, 0]]), np.concatenate([[start], forces[inside]])

    def released(self, known: float, seconds: float = 1.5) -> float:
        """Time from `known` until the force is zero and stays zero [s]; at least zero."""
        time.sleep(max(0.0, known + 0.4 - time.monotonic()))
        end = time.monotonic() + seconds
        while True:
            t, force = self.held(known)
            pushing = np.flatnonzero(force > 1e-9)
            if not len(pushing):
                return 0.0
            last = pushing[-1]
            if last + 1 < len(t):
                return float(t[last + 1] - known)
            _in_time(end, f"still {force[-1]:.2f} N on the hand, {seconds:g} s after the fault")
            time.sleep(0.02)

    def first_free(self, begin: float, end: float = np.inf) -> float:
        """Time from `begin` until the first zero force [s]; infinite if there is none."""
        t, force = self.held(begin, end)
        free = np.flatnonzero(force == 0.0)
        return float(t[free[0]] - begin) if len(free) else np.inf

    def steepest(self, begin: float, end: float = np.inf) -> float:
        """Fastest growth of the force in the order of sending, also after zero wrenches of the guardian [N/s].

        A wrench that was sent before the guardian's zero but arrives after it does not count as growth.
        """
        felt = self.mock_leader.wrenches
        felt = felt[(felt[:, 0] >= begin) & (felt[:, 0] <= end)]
        sent = np.where(felt[:, 2] > 0.0, felt[:, 2], felt[:, 1])  # the guardian's zeros have no stamp
        order = np.argsort(sent, kind="stable")
        forces, sent, own = np.linalg.norm(felt[order, 3:6], axis=1), sent[order], felt[order, 2] > 0.0
        growth, steps = np.diff(forces), np.clip(np.diff(sent), 1.0 / self.rate, 1.5 / self.rate)
        grown = own[1:] & (growth > 0.0)
        return float((growth[grown] / steps[grown]).max(initial=0.0))


def alive(pid: int) -> bool:
    """Whether a process with this id exists."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def _in_time(end: float, otherwise: str) -> None:
    if time.monotonic() >= end:
        raise PalpateError(otherwise, mend="see what the haptic node printed; on a busy machine try again")
