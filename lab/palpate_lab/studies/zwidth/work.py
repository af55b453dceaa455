"""The work of ``palpate study zwidth``."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import partial

import numpy as np

from palpate.arm import Arm
from palpate.base.arrays.checks import finite_or_none
from palpate.base.sweep import Axis, Label, Swept, sweep
from palpate.base.sweep.grid import Point
from palpate.devices.certificate import DeviceModel, trials
from palpate.devices.certificate.classical import colgate_brown
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.zwidth.result import Panel, StudyResult

RATES = (250.0, 1000.0, 4000.0)  # [Hz]
DELAYS = (0.0, 2e-3, 10e-3)  # [s]
STIFFNESS, DAMPING = (30.0, 100_000.0), (0.1, 300.0)  # ranges of the map [N/m], [N s/m]
POINTS, FINE = (34, 22), 120  # logarithmically spaced points of the map; points of the boundary lines
_TOWARDS_USER = 1  # axis of L towards the user


def mtm() -> DeviceModel:
    """The simulated MTM in its home pose as a one-axis device: its handle moves along y of L without rotation.

    With q' = M^-1 J^T (J M^-1 J^T)^-1 e for a unit velocity e: mass q'^T M q', damping sum Fv q'^2, dry friction
    sum Fc |q'|; resolution: one count of the encoder with the largest effect on the handle.
    """
    arm = Arm.mtm("right")
    plant, J = arm.leader_options(), arm.jacobian(arm.home)
    M = arm.mass_matrix(arm.home) + np.diag(plant.rotor_inertia)
    toward = np.linalg.solve(M, J.T)
    rates = toward @ np.linalg.solve(J @ toward, np.eye(6)[_TOWARDS_USER])
    counts = np.abs(J[_TOWARDS_USER] @ plant.coupling) * plant.encoder_step
    return DeviceModel(
        mass=float(rates @ M @ rates),
        damping=float(plant.viscous @ rates**2),
        friction=float(plant.coulomb @ np.abs(rates)),
        quantum=float(counts.max()),
    )


def run(
    device: DeviceModel, rates: tuple[float, ...], delays: tuple[float, ...], sweep: Sweeper = sweep,
    points: tuple[int, int] = POINTS,
) -> StudyResult:  # fmt: skip
    """The map and the analytic bounds per rate and delay, with the keys of docs/json.md."""
    grid = {
        "rate": Axis(rates, "Hz", "rate of the haptic cycle"),
        "delay": Axis(delays, "s", "from the measurement to the force"),
        "B": Axis(np.geomspace(*DAMPING, points[1]), "N s/m", "damping of the wall"),
        "K": Axis(np.geomspace(*STIFFNESS, points[0]), "N/m", "stiffness of the wall"),
    }
    labels = {"stable": Label("1", "no press and no tap leaves an oscillation that lasts")}
    swept = sweep(partial(wall, device), grid, labels=labels)
    numbers = {f"{name}_SI": value for name, value in asdict(device).items() if isinstance(value, float)}
    panels = [_panel(device, swept, i, j) for i in range(len(rates)) for j in range(len(delays))]
    return {"simulated": True, "device": numbers, "hand": device.hands[0].name, "panels": panels}


def wall(device: DeviceModel, point: Point, seed: int) -> dict[str, bool]:
    """Whether this wall is stable. Only the device's jitter is random, with its own fixed seed."""
    at = replace(device, rate=point["rate"], delay=point["delay"])
    (hand,) = at.hands
    return {"stable": not trials.oscillates(at, hand, point["K"], point["B"])}


def _panel(device: DeviceModel, swept: Swept, i: int, j: int) -> Panel:
    rate, delay, B, K = (np.array(axis.values, float) for axis in swept.grid.axes.values())
    at = replace(device, rate=float(rate[i]), delay=float(delay[j]))
    loop, fine = at.loop(at.hands[0], lubricated=False), np.geomspace(B[0], B[-1], FINE)
    return {
        "rate_Hz": at.rate,
        "delay_s": at.delay,
        "B_N_s_per_m": B.tolist(),
        "K_N_per_m": K.tolist(),
        "stable": (swept.array("stable")[i, j] == 1.0).tolist(),
        "line_B_N_s_per_m": fine.tolist(),
        "boundary_N_per_m": [finite_or_none(loop.K_max(b)[0]) for b in fine],
        "colgate_brown_N_per_m": [colgate_brown(at.damping, b, 1.0 / at.rate, at.delay) for b in fine],
    }
