"""The simulated dVRK on ROS 2: arms, console, pedals and teleoperations under the names that the real one has."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from palpate.errors import PalpateError
from palpate.ros import build
from palpate.simulators import dvrk

FASTEST = 1000.0
"""Of what the arms measure [Hz]; their own servos run at 1500 Hz."""


def start(
    arms: Sequence[str],
    *,
    rate: float = 100.0,
    network: bool = False,
    on_progress: build.Progress = lambda _: None,
) -> Any:
    """Begin; the robot runs, outside the interpreter, until its `stop()`.

    Args:
        arms: names, such as MTMR and PSM1.
        rate: of what the arms measure [Hz].
        network: other machines see it, too; otherwise this one alone.
        on_progress: told what is compiled on first use.

    Raises:
        ArmError: there is no such arm.
        PalpateError: a rate that cannot be.
        RosMissingError: ROS 2 is not here, or our part of it does not compile.
    """
    if not 1.0 <= rate <= FASTEST:
        raise PalpateError(f"--rate {rate:g}: the arms cannot tell at {rate:g} Hz", mend=f"from 1 to {FASTEST:g} Hz")
    robot, twin = dvrk.system(arms), dvrk.system(arms)
    native = build.load(on_progress)
    return native.Robot(native.Context(network=network), robot, twin, rate)


class Meter:
    """What a running robot reaches, from one look to the next."""

    def __init__(self, robot: Any) -> None:
        self._robot = robot
        self._before = self._now()

    def look(self) -> dict[str, float]:
        """Since the last look: `rate` of measures [Hz], servo ticks `missed`, `commands`, `cores` of this process."""
        before, self._before = self._before, self._now()
        seconds, rounds, missed, commands, cpu = (now - then for now, then in zip(self._before, before, strict=True))
        return {"rate": rounds / seconds, "missed": missed, "commands": commands, "cores": cpu / seconds}

    def _now(self) -> tuple[float, float, float, float, float]:
        robot = self._robot
        return time.monotonic(), robot.rounds, robot.missed, robot.commands, time.process_time()
