"""The simulated dVRK on ROS 2: arms, console, pedals and teleoperation under the topic names of the real robot."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from typing import Any

from palpate.base.errors import PalpateError
from palpate.ros import build
from palpate.simulators import dvrk

FASTEST = 1000.0
"""Highest rate of the measured states [Hz], which is the default: haptics needs it. The servos run at 1500 Hz."""
_SEARCH = 1.0  # time in which running programs are found [s]


def start(
    arms: Sequence[str],
    *,
    rate: float = FASTEST,
    network: bool = False,
    head_sensor: bool = False,
    force: bool = False,
    on_progress: build.Progress = lambda _: None,
) -> Any:
    """Start the robot, which runs outside the interpreter until its `stop()`.

    Args:
        arms: names, such as MTMR and PSM1.
        rate: rate of the measured states [Hz].
        network: communicate with other machines; otherwise only within this one.
        head_sensor: a head sensor reports the operator's presence; otherwise the coag pedal does.
        force: start even if another program has these arms already.
        on_progress: called with a line on each compilation at first use.

    Raises:
        ArmError: no arm has this name.
        PalpateError: the rate is out of range, or another program publishes one of these arms.
        RosMissingError: ROS 2 is not installed, or Palpate's part does not compile.
    """
    if not 1.0 <= rate <= FASTEST:
        raise PalpateError(
            f"--rate {rate:g}: the arms cannot publish at {rate:g} Hz", mend=f"choose from 1 to {FASTEST:g} Hz"
        )
    robot, twin = dvrk.system(arms, head_sensor=head_sensor), dvrk.system(arms)
    native = build.load(on_progress)
    if not force:
        require_free(arms, network)
    return native.Robot(native.Context(network=network), robot, twin, rate)


def require_free(arms: Sequence[str], network: bool = False) -> None:
    """Refuse names that another program publishes: two arms of one name would both obey, and nobody knows which speaks.

    Raises:
        PalpateError: the message names the topic and the program.
    """
    from palpate.ros import topic

    names = [*(f"/{arm}/{part}" for arm in arms for part in ("measured_cp", "measured_js", "operating_state")),
             "/console/operator_present"]  # fmt: skip
    with topic.node(network, f"palpate_sim_search_{os.getpid()}") as here:
        end = time.monotonic() + _SEARCH
        while time.monotonic() < end:
            topic.spin(here, 0.05)
            taken = [name for name in names if here.count_publishers(name)]
            if taken:
                nodes = _names(here, taken)
                while _UNNAMED in nodes and time.monotonic() < end:  # discovery tells a publisher before its node
                    topic.spin(here, 0.05)
                    nodes = _names(here, taken)
                raise PalpateError(
                    f"{', '.join(taken[:3])}{' ...' if len(taken) > 3 else ''} exist already, of {', '.join(nodes)}",
                    why="a second arm of this name would obey the same commands, and its states would mix with theirs",
                    mend="end that program, give another ROS_DOMAIN_ID, or insist with --force",
                )


_UNNAMED = "a program that has not told its name"


def _names(here: Any, topics: Sequence[str]) -> list[str]:
    """Full names of the nodes that publish one of these topics."""
    ends = [end for name in topics for end in here.get_publishers_info_by_topic(name)]
    return sorted({_UNNAMED if "UNKNOWN" in end.node_name else _full_name(end) for end in ends})


def _full_name(end: Any) -> str:
    return f"{end.node_namespace.rstrip('/')}/{end.node_name}"


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
