"""`palpate bench execution --ros`: how long an arm over ROS 2 takes to rest after a stop that another process requests.

The arm is `palpate ros sim`, the motion is `palpate ros move`, and the request is a message on its topic ~/stop from
this process. All times are of one clock: the request's, and the stamps of the arm's set points and measurements.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.errors import PalpateError
from palpate.planning.problem import Problem
from palpate.scene import Scene
from palpate_lab.verify.bench.execution import rested, row

WAYS = ("servo_jp", "move_jp")
_ARM = "PSM1"
_RATE = 500  # of the measurements [Hz]
_AFTER = 0.3  # time that is looked at after a request [s]
_TIMEOUT = 60.0  # of each step [s]
_DOMAINS = 102  # up to domain 101 no port collides with ports of the system
_SPEEDS = {"servo_jp": 1.0, "move_jp": 0.7}  # so that the tip is about as fast by both
_START, _GOAL = np.array([-0.65, 0.0, 0.13, 0, 0, 0]), np.array([0.65, 0.0, 0.13, 0, 0, 0])  # [rad, m]
_SCENE = """
objects: [{name: ball, sphere: {radius: 0.005}, pose: {xyz: [0, 0.1, 0.1]}}]
arms:
  leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
  follower: {base: {xyz: [0, 0, 0.12]}}
planning: {arm: PSM1, clearance: 3 mm, speed: 0.28}
operator: {path: [{t: 0, xyz: [0.05, 0, 0]}]}
"""


def run(stops: int = 20, on_progress: Callable[[str], None] = lambda _: None) -> list[dict[str, Any]]:
    """Rows for servo_jp and for move_jp: times [s] from the request until set point, place and speed of the tip rest.

    Raises:
        RosMissingError: ROS 2 is not installed. PalpateError: the simulated arm or a motion does not do as it should.
    """
    from palpate import ros
    from palpate.ros import topic

    ros.load(on_progress)
    with tempfile.TemporaryDirectory() as name, _own_domain():
        folder = Path(name)
        problem = _planned(folder)
        with _robot(), topic.node(name="palpate_bench_execution") as here:
            stand = _Stand(here, folder, problem.robot.arm)
            stand.home()
            rows = []
            for by in WAYS:
                places = np.linspace(-0.1, 0.1, stops)  # of the first joint at the requests [rad]
                found = np.array([stand.stop(by, place) for place in places])
                rows.append(row(f"ROS 2, {by}", found[:, :3], float(found[:, 3].mean())) | {"load": os.getloadavg()[0]})
                worst = 1e3 * rows[-1]["slow_worst_s"]
                on_progress(f"{by}: the tool rests after {worst:.0f} ms at worst, of {stops} stops")
    return rows


def _planned(folder: Path) -> Problem:
    """Write the scene and a straight plan that swings the instrument to the side; returns the problem."""
    (folder / "scene.yaml").write_text(_SCENE)
    problem = Problem.of(Scene.load(folder / "scene.yaml"))
    problem.plan(_START, _GOAL, timeout=_TIMEOUT).save(folder / "plan.yaml", problem.robot.arm)
    return problem


@contextmanager
def _own_domain() -> Iterator[None]:
    """No other robot hears what this benchmark sends."""
    before = {key: os.environ.get(key) for key in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE")}
    domain = (int(before["ROS_DOMAIN_ID"] or 0) + 1 + os.getpid() % (_DOMAINS - 1)) % _DOMAINS
    os.environ |= {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    try:
        yield
    finally:
        for key, value in before.items():
            os.environ.pop(key, None)
            if value is not None:
                os.environ[key] = value


@contextmanager
def _robot() -> Iterator[None]:
    """The simulated arm in a process of its own."""
    command = [sys.executable, "-m", "palpate", "ros", "sim", "--arms", _ARM, "--rate", str(_RATE)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout
        if not any("Ctrl-C" in line for line in process.stdout):
            raise PalpateError("palpate ros sim ended by itself", mend="run it alone to see why")
        yield
    finally:
        process.terminate()
        process.communicate()


class _Stand:
    """Watches the arm, and stops motions of it."""

    def __init__(self, here: Any, folder: Path, arm: Arm) -> None:
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Empty

        from palpate.ros.crtk_arm import CrtkArm
        from palpate.ros.topic import message_type

        self._here, self._folder, self._model = here, folder, arm
        self._arm = CrtkArm(here, _ARM, "move_jp")
        self._state = here.create_publisher(message_type("crtk_msgs/StringStamped"), f"/{_ARM}/state_command", 1)
        self._stop = here.create_publisher(Empty, f"/palpate_move_{_ARM}/stop", 1)
        self._rows: dict[str, list[Array]] = {"measured_js": [], "setpoint_js": []}
        for name, rows in self._rows.items():
            here.create_subscription(JointState, f"/{_ARM}/{name}", lambda m, rows=rows: rows.append(_times(m)), 100)

    def home(self) -> None:
        """Enable and home the arm."""
        from palpate.ros.topic import message_type

        kind = message_type("crtk_msgs/StringStamped")
        self._until(lambda: bool(self._state.get_subscription_count()), "the arm")
        for text in ("enable", "home"):
            self._state.publish(kind(string=text))
        self._until(lambda: not self._arm.refusal(starting=True), "the arm to be homed")
        self._arm.find()

    def stop(self, by: str, place: float) -> tuple[float, float, float, float]:
        """Stop a motion when the first joint passes a place [rad]; see `rested`, and the speed at the request [m/s]."""
        from std_msgs.msg import Empty

        self._until(lambda: self._near(_START, send=True), "the arm to be at the start")
        command = ["ros", "move", str(self._folder / "plan.yaml"), "--arm", _ARM, "--by", by]
        process = subprocess.Popen(
            [sys.executable, "-m", "palpate", *command, "--speed", str(_SPEEDS[by])], stdout=subprocess.PIPE, text=True
        )
        try:
            self._until(lambda: self._q[0] > place or process.poll() is not None, "the motion")
            if process.poll() is not None:
                raise PalpateError("a motion ended before it was stopped", why=process.communicate()[0].strip())
            asked = time.time()
            self._stop.publish(Empty())
            self._until(lambda: process.poll() is not None, "the end of the motion")
        finally:
            process.kill()
            process.communicate()
        if self._q[0] > 0.5 * (_GOAL[0] + place):
            raise PalpateError("a motion was not stopped", mend="a less busy machine")
        return self._judged(asked)

    def _judged(self, asked: float) -> tuple[float, float, float, float]:
        self._until(lambda: time.time() > asked + 1.5 * _AFTER, "what follows")
        measured, wanted = (np.array(self._rows[name]) for name in ("measured_js", "setpoint_js"))
        measured = measured[(measured[:, 0] > asked) & (measured[:, 0] < asked + _AFTER)]
        n = self._model.n
        q, v = measured[:, 1 : n + 1], measured[:, n + 1 :]
        p = np.array([self._model.fk(one)[:3, 3] for one in q])
        speed = np.array([np.linalg.norm(self._model.jacobian(a)[:3] @ b) for a, b in zip(q, v, strict=True)])
        held = wanted[np.searchsorted(wanted[:, 0], measured[:, 0]).clip(max=len(wanted) - 1), 1 : n + 1]
        return *rested(measured[:, 0] - asked, held, p, speed), float(speed[0])

    def _near(self, q: Array, send: bool) -> bool:
        """True when the arm rests at q (n,); sends it there."""
        near = self._arm.q is not None and bool(np.abs(self._arm.q - q).max() < 5e-4)
        if near and not self._arm.is_busy:
            for rows in self._rows.values():
                rows.clear()
            return True
        if send and not self._arm.is_busy:
            self._arm.send(q)
            self._until(lambda: self._arm.is_busy or self._near(q, send=False), "a move")
        return False

    @property
    def _q(self) -> Array:
        assert self._arm.q is not None
        return self._arm.q

    def _until(self, condition: Callable[[], bool], what: str) -> None:
        from palpate.ros import topic

        end = time.monotonic() + _TIMEOUT
        while not condition():
            if time.monotonic() > end:
                raise PalpateError(f"waited {_TIMEOUT:g} s for {what}", mend="a less busy machine")
            topic.spin(self._here, 0.01)


def _times(message: Any) -> Array:
    """Stamp [s], positions and velocities of a message, in one row."""
    stamp = message.header.stamp
    return np.array([stamp.sec + 1e-9 * stamp.nanosec, *message.position, *message.velocity])
