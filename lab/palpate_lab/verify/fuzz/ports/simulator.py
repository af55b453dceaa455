"""The simulated dVRK: any command with any numbers, as its topics deliver them. What it measures stays finite.

A simulated hand that pulls with a million newtons may throw an arm out of all numbers: the robot then reports a fault,
and the arm is where it started.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from palpate import _dvrk
from palpate.simulators import dvrk
from palpate_lab.verify.fuzz import FaultError
from palpate_lab.verify.fuzz.ports import values

ARMS = {"MTMR": 1, "MTML": 1, "PSM1": 2, "ECM": 4}
_SIDES = ("position_positive", "position_negative", "orientation_positive", "orientation_negative")
_IMPEDANCE = 11  # number of the payload
_TICKS = 1  # ticks of 1/3 ms between two messages


@cache
def _targets() -> list[tuple[str, str, int]]:
    """Component, verb and payload of each command."""
    kinds = {0: ["system"], 1: ["console"], 2: ["footpedals"], 4: ["MTMR_PSM1"], 5: ["MTML_MTMR_ECM"],
             6: ["SUJ/PSM1", "SUJ/ECM"], 7: ["SUJ"], 8: ["endoscope_focus"]}  # fmt: skip
    found = []
    for kind, mask, verb, payload in _dvrk.verbs():
        names = [name for name, bit in ARMS.items() if mask & bit] if kind == 3 else kinds[kind]
        found += [(name, verb, payload) for name in names]
    return found


@cache
def _specs() -> list[_dvrk.ArmSpec]:
    return [dvrk.arm(name) for name in ARMS]


def case(rng: np.random.Generator, messages: int, by_socket: bool) -> int:
    """Send commands; returns their number. Raises FaultError."""
    robot, targets = dvrk.system(_specs()), _targets()
    if rng.random() < 0.6:
        robot.send("system", "power_on") if ("system", "power_on", 0) in targets else None
        for arm in ARMS:
            robot.send(arm, "state_command", "home")
        robot.step(300)
    for k in range(messages):
        component, verb, payload = targets[rng.integers(len(targets))]
        robot.send(component, verb, _value(rng, payload))
        robot.step(_TICKS)
        if k % 25 == 24:
            _judge(robot)
    return messages


def _judge(robot: Any) -> None:
    robot.events()
    for arm in robot.arms:
        state = robot.state(arm)
        parts = [*(state["measured_js"].values() if state["joints_valid"] else ())]
        parts += [state[name] for name in ("measured_cp", "measured_cv", "measured_cf") if state["cartesian_valid"]]
        parts += [state[name] for name in ("SUJ/measured_cp", "SUJ/local/measured_cp") if name in state]
        for part in parts:
            if not np.isfinite(np.asarray(part, dtype=float)).all():
                raise FaultError(f"a measurement of {arm} is not finite: {part}")


def _value(rng: np.random.Generator, payload: int) -> Any:
    """A value for a payload, by its number in `simulators/dvrk/messages.hpp`."""
    half = {key: values.array(rng, 3) for key in ("p", "d", "bias", "deadband")} if payload == _IMPEDANCE else {}
    makers: list[Any] = [
        lambda: None,
        lambda: bool(rng.integers(2)),
        lambda: values.number(rng),
        lambda: values.text(rng).replace("\0", ""),
        lambda: values.pick(rng, (0, 1, 2, -1, 99)),
        lambda: values.array(rng, int(rng.integers(10))),
        lambda: values.array(rng, int(rng.integers(10))),
        lambda: values.matrix(rng),
        lambda: values.matrix(rng)[:3, :3],
        lambda: values.array(rng, 6),
        lambda: {"pose": values.matrix(rng), "twist": values.array(rng, 6), "wrench": values.array(rng, 6)},
        lambda: (
            {"force_position": values.array(rng, 3), "force_orientation": values.matrix(rng)[:3, :3]}
            | {side: half for side in _SIDES if rng.random() < 0.5}
        ),
    ]
    return makers[payload]() if payload < len(makers) else None
