"""One segment of `palpate soak ros`: a robot, a node and a hand, from their start to their end."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Self

import numpy as np

from palpate.base.errors import PalpateError
from palpate_lab.verify.processes import end as end_process
from palpate_lab.verify.soak.ros_row import RATE, Row

_SCENE = f"""
objects:
  - {{name: wall, plane: {{size: 0.12}}, pose: {{xyz: [0, -0.387, -0.1288], rpy_deg: [-90, 0, 0]}}, stiffness: 300,
     damping: 2}}
arms: {{leader: {{base: {{xyz: [0, 0, 0]}}, start: [0, 0, 0, 0, 0, 0, 0]}}, follower: {{bandwidth: 0}}}}
mapping: {{scale: 1.0, align_rate: 0}}
rates: {{haptic: {RATE:g}}}
operator: {{path: [{{t: 0.2, xyz: [0, -0.3645, -0.1288]}}, {{t: 1, xyz: [0, -0.37, -0.1288]}}]}}
record: {{rate: 1, report: false}}
"""
_TOP, _BOTTOM = -0.3645, -0.44  # range of the hand along the wall's normal [m]
_SPEED, _RETREAT = 0.015, 0.012  # [m/s], [m]
_TOUCH = 0.4  # force at which the hand turns back [N]
_PERIOD = 0.02  # interval of the hand's motion [s]
_START = 120.0  # timeout of each step of the start [s]


class Segment:
    """A context manager that starts robot and node, and ends both.

    Args:
        number: number of the segment, from 1.
        folder: folder for the records of the node.
    """

    def __init__(self, number: int, folder: Path) -> None:
        self._number, self._lines, self._touches = number, 0, 0
        self._begin = time.monotonic()
        self._work = tempfile.TemporaryDirectory(prefix="palpate-soak-", dir=folder)
        self._processes: dict[str, subprocess.Popen[str]] = {}
        self._here: Any = None
        self._force = 0.0
        self._diagnostics: dict[str, str] = {}
        self._wrenches_before = 0
        self._y, self._way, self._turn = _TOP, -1.0, _TOP

    def __enter__(self) -> Self:
        """Start everything; the counts begin when the first wrench has arrived."""
        try:
            self._open()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *error: object) -> None:
        """End the node first, then the robot."""
        for name in ("haptics", "robot"):
            process = self._processes.get(name)
            if process is not None:
                end_process(process, 20.0)
        if self._here is not None:
            self._stack.__exit__(None, None, None)
        self._work.cleanup()

    @property
    def t(self) -> float:
        """Time since the begin of the counts [s]."""
        return time.monotonic() - self._begin

    def press(self, seconds: float) -> None:
        """Move the hand to the wall and back for a time [s], or until a process ends."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and not self._ended():
            self._y += self._way * _SPEED * _PERIOD
            if self._way < 0.0 and (self._force > _TOUCH or self._y < _BOTTOM):
                self._touches += self._force > _TOUCH
                self._way, self._turn = 1.0, self._y
            elif self._way > 0.0 and self._y > min(self._turn + _RETREAT, _TOP):
                self._way = -1.0
            self._goal.pose.position.y = self._y
            self._hand.publish(self._goal)
            self._spin(_PERIOD)

    def row(self) -> Row:
        """The counts so far."""
        values, memory = self._diagnostics, {name: _memory(process.pid) for name, process in self._processes.items()}
        taken, left_out = (int(x) for x in values.get("messages taken / left out", "0 / 0").split(" / "))
        return Row(
            segment=self._number,
            t_s=self.t,
            wrenches=int(values.get("wrenches sent", 0)) - self._wrenches_before,
            states=taken - self._states_before,
            left_out=left_out,
            guarded=int(values.get("guardian took over", 0)),
            touches=self._touches,
            lines=self._lines,
            load=os.getloadavg()[0],
            memory_MB={**memory, "guardian": _memory(self._guardian)},
            ended=self._ended(),
        )

    def _open(self) -> None:
        from palpate import ros
        from palpate.ros import topic

        ros.load(lambda text: print(text, file=sys.stderr))
        work = Path(self._work.name)
        (work / "wall.yaml").write_text(_SCENE)
        self._start("robot", "sim", "--arms", "MTMR", "PSM1", "--rate", f"{RATE:g}")
        self._stack = topic.node()
        self._here = self._stack.__enter__()
        self._subscribe()
        for verb in ("power_on", "home"):
            topic.publish(self._here, f"/system/{verb}", "std_msgs/msg/Empty", "{}", None)
        self._await(self._homed, "the robot does not home")
        options = ("--follower", "virtual", "--teleop", "none", "--out", str(work / "runs"))
        self._start("haptics", "haptics", str(work / "wall.yaml"), *options)
        topic.publish(self._here, "/console/emulate_operator_present", "sensor_msgs/msg/Joy", "buttons: [1]", None)
        self._await(lambda: int(self._diagnostics.get("wrenches sent", 0)) > 0, "the node sends no wrench")
        self._goal = self._pose
        self._y = self._turn = self._goal.pose.position.y
        self._wrenches_before = int(self._diagnostics["wrenches sent"])
        self._states_before = int(self._diagnostics["messages taken / left out"].split(" / ")[0])
        self._begin = time.monotonic()

    def _subscribe(self) -> None:
        from diagnostic_msgs.msg import DiagnosticArray
        from geometry_msgs.msg import PoseStamped, WrenchStamped
        from rclpy.qos import QoSProfile, ReliabilityPolicy

        newest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._pose: Any = None
        self._here.create_subscription(DiagnosticArray, "/diagnostics", self._diagnosed, 1)
        self._here.create_subscription(WrenchStamped, "/MTMR/body/servo_cf", self._felt, newest)
        self._poses = self._here.create_subscription(PoseStamped, "/MTMR/measured_cp", self._seen, newest)
        self._hand = self._here.create_publisher(PoseStamped, "/MTMR/hand/servo_cp", 10)

    def _diagnosed(self, message: Any) -> None:
        self._diagnostics = {value.key: value.value for value in message.status[0].values}

    def _felt(self, message: Any) -> None:
        f = message.wrench.force
        self._force = float(np.sqrt(f.x**2 + f.y**2 + f.z**2))

    def _seen(self, message: Any) -> None:
        if message.header.stamp.sec:  # a stamp of zero marks an arm without valid pose
            self._pose = message

    def _start(self, name: str, *arguments: str) -> None:
        command = [sys.executable, "-m", "palpate", "ros", *arguments]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self._processes[name] = process
        ready = threading.Event()

        def read() -> None:
            assert process.stdout
            for line in process.stdout:
                self._lines += name == "haptics"
                if "guardian process" in line:
                    self._guardian = int(line.rsplit(" ", 1)[1])
                if "guardian process" in line or "Ctrl-C" in line:
                    ready.set()

        threading.Thread(target=read, daemon=True).start()
        if not ready.wait(_START):
            raise PalpateError(f"palpate ros {arguments[0]} does not start", mend="run it alone to see why")

    def _homed(self) -> bool:
        return self._pose is not None and abs(self._pose.pose.position.y - _TOP) < 1e-3

    def _await(self, true: Callable[[], bool], otherwise: str) -> None:
        end = time.monotonic() + _START
        while not true():
            if time.monotonic() > end:
                raise PalpateError(otherwise, why=f"waited {_START:g} s", mend="run palpate ros haptics alone")
            self._spin(0.05)

    def _spin(self, seconds: float) -> None:
        """Handle messages for a time [s]; of the fast topics, only the newest message of each turn."""
        from palpate.ros.topic import spin

        end = time.monotonic() + seconds
        spin(self._here, 0.0)
        time.sleep(max(0.0, 0.5 * (end - time.monotonic())))
        spin(self._here, 0.0)
        spin(self._here, 0.0)
        time.sleep(max(0.0, end - time.monotonic()))

    def _ended(self) -> bool:
        return any(process.poll() is not None for process in self._processes.values())


def _memory(pid: int) -> float:
    """Resident memory of a process [MB]; 0 if it has ended."""
    try:
        fields = Path(f"/proc/{pid}/statm").read_text().split()
    except OSError:
        return 0.0
    return int(fields[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
