"""The simulated dVRK on ROS 2: arms, console, pedals and teleoperation under the topic names of the real robot."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from palpate.errors import PalpateError
from palpate.ros import build
from palpate.simulators import dvrk

FASTEST = 1000.0
"""Highest rate of the measured states [Hz]; the simulated servos run at 1500 Hz."""


def start(
    arms: Sequence[str],
    *,
    rate: float = 100.0,
    network: bool = False,
    head_sensor: bool = False,
    on_progress: build.Progress = lambda _: None,
) -> Any:
    """Start the robot, which runs outside the interpreter until its `stop()`.

    Args:
        arms: names, such as MTMR and PSM1.
        rate: rate of the measured states [Hz].
        network: communicate with other machines; otherwise only within this one.
        head_sensor: a head sensor reports the operator's presence; otherwise the coag pedal does.
        on_progress: called with a line on each compilation at first use.

    Raises:
        ArmError: no arm has this name.
        PalpateError: the rate is out of range.
        RosMissingError: ROS 2 is not installed, or Palpate's part does not compile.
    """
    if not 1.0 <= rate <= FASTEST:
        raise PalpateError(
            f"--rate {rate:g}: the arms cannot publish at {rate:g} Hz", mend=f"choose from 1 to {FASTEST:g} Hz"
        )
    robot, twin = dvrk.system(arms, head_sensor=head_sensor), dvrk.system(arms)
    native = build.load(on_progress)
    return native.Robot(native.Context(network=network), robot, twin, rate)


class Meter:
    """Measures rates and load of a running robot between two readings."""

    def __init__(self, robot: Any) -> None:
        self._robot = robot
        self._before = self._now()

    def read(self) -> dict[str, float]:
        """Values since the last reading: state `rate` [Hz], `missed` servo ticks, `commands`, CPU `cores` in use."""
        before, self._before = self._before, self._now()
        seconds, rounds, missed, commands, cpu = (now - then for now, then in zip(self._before, before, strict=True))
        return {"rate": rounds / seconds, "missed": missed, "commands": commands, "cores": cpu / seconds}

    def _now(self) -> tuple[float, float, float, float, float]:
        robot = self._robot
        return time.monotonic(), robot.rounds, robot.missed, robot.commands, time.process_time()
