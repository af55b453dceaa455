"""The work of ``palpate study laws``."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from rich.table import Table

from palpate import _core
from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate.record.ticks import STATUS
from palpate_lab.studies._command import Sweeper

LAWS = ("stiffness", "impedance", "impedance-shaped", "admittance")
FREQUENCIES = (0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0)  # [Hz]
STIFFNESSES = (50.0, 100.0, 400.0, 1000.0, 2000.0)  # [N/m]
HANDS = {"slow": 0.05, "fast": 0.5}  # peak speed of the hand's intended motion [m/s]
WRONG = (0.7, 1.0, 1.3)  # masses and rotor inertias of the controller's model relative to the true values
MIDDLE = 400.0  # stiffness for the tests of wrong masses [N/m]
VIRTUAL_MASS = 0.2  # virtual mass of the laws that shape inertia [kg]; the arm's own is about 0.56 along the axis
NOTICED = 0.10  # noticeable relative change of stiffness or force (Weber fraction 7 to 10 %)

_AXIS = 1  # axis of L of the hand's motion, towards the user
_FARTHEST = 0.03  # largest amplitude of the hand's motion [m]
_FORCE = 2.5  # largest force of the spring [N]
_DT = 1e-3  # period of the cycle [s]
_SUBSTEPS = 10


@dataclass(frozen=True)
class Case:
    """One experiment."""

    law: str
    """One of `LAWS`."""
    f_Hz: float
    K_N_per_m: float
    hand: str
    """One of `HANDS`."""
    model_scale: float = 1.0
    """Masses and rotor inertias of the controller's model relative to the true values; gravity is calibrated."""


@dataclass(frozen=True)
class Outcome(Case):
    """Result of one experiment."""

    felt_N_per_m: float = 0.0
    """Real part of -F_cell / x: the stiffness at the hand."""
    felt_damping_N_s_per_m: float = 0.0
    """Imaginary part of -F_cell / x over 2 pi f."""
    stiffness_error: float = 0.0
    """Relative error of the stiffness at the hand [-]."""
    impedance_error: float = 0.0
    """Relative error of stiffness and friction together, |-F_cell / x - K| / K [-]."""
    force_error: float = 0.0
    """Rms of F_cell - F_desired over rms of F_desired, without means [-]."""
    force_rms_N: float = 0.0
    """Rms of the desired force."""
    motion_mm: float = 0.0
    """Amplitude of the handle."""
    peak_speed_m_s: float = 0.0
    neglected_N: float = 0.0
    """Largest inertial and Coriolis force that the law reports as not compensated."""
    too_fast: bool = False
    """True if the running loop warned about the speed."""


GRID = {
    "law": Axis(LAWS),
    "f_Hz": Axis(FREQUENCIES, "Hz", "frequency of the motion"),
    "K_N_per_m": Axis(STIFFNESSES, "N/m", "rendered stiffness"),
    "hand": Axis(HANDS),
    "model_scale": Axis(WRONG, "", "masses the controller believes in over the true ones"),
}


def included(point: Point) -> bool:
    """All laws, frequencies, stiffnesses and hands; wrong masses only at one stiffness with the fast hand."""
    return point["model_scale"] == 1.0 or (point["K_N_per_m"], point["hand"]) == (MIDDLE, "fast")


def run(sweep: Sweeper = sweep) -> list[Outcome]:
    """All outcomes, those with wrong masses last."""
    swept = sweep(measure, GRID, where=included)
    return sorted((Outcome(**row) for row in swept.rows()), key=lambda o: o.model_scale != 1.0)


def measure(point: Point, seed: int) -> dict[str, float]:
    """Run one experiment of the sweep, which is deterministic."""
    return {key: value for key, value in asdict(experiment(Case(**point))).items() if key not in point}


def experiment(case: Case) -> Outcome:
    """Run one experiment: settling time, then whole periods of the motion."""
    f = case.f_Hz
    settle, periods = max(0.4, 0.5 / f), max(1, int(0.8 * f))
    t, x, F_cell, F_wanted, commands = _bench(case, settle + periods / f)
    kept = t >= settle
    phase = np.exp(-2j * np.pi * f * t[kept])
    x, cell, wanted = x[kept], F_cell[kept], F_wanted[kept]
    felt = -(cell @ phase) / (x @ phase)
    rms = float(np.std(wanted))
    return Outcome(
        **asdict(case),
        felt_N_per_m=float(felt.real),
        felt_damping_N_s_per_m=float(felt.imag / (2 * np.pi * f)),
        stiffness_error=float(abs(felt.real - case.K_N_per_m) / case.K_N_per_m),
        impedance_error=float(abs(felt - case.K_N_per_m) / case.K_N_per_m),
        force_error=float(np.std(cell - wanted) / rms),
        force_rms_N=rms,
        motion_mm=float(2e3 * abs(np.mean(x * phase))),
        peak_speed_m_s=float(np.abs(np.gradient(x, _DT)).max()),
        neglected_N=float(commands[kept, 0].max()),
        too_fast=bool(commands[kept, 1].any()),
    )


def trace(law: str, f: float, K: float = MIDDLE) -> tuple[str, Array, Array, Array]:
    """(title, time [s], desired force [N], load cell [N]) of two periods, fast hand."""
    t, _, F_cell, F_wanted, _ = _bench(Case(law, f, K, "fast"), 4.0 / f)
    kept = t >= 2.0 / f
    return f"{law}, {f:g} Hz", t[kept] - 2.0 / f, F_wanted[kept], F_cell[kept]


def _options(case: Case, arm: Arm, plant: _core.LeaderOptions) -> _core.TorqueOptions:
    o = _core.TorqueOptions()
    o.law = case.law.removesuffix("-shaped")
    o.laws.virtual_mass = VIRTUAL_MASS
    o.laws.shape_inertia = case.law.endswith("-shaped")
    o.rotor_inertia = case.model_scale * plant.rotor_inertia
    o.platform_gain = 0.5 if arm.has_platform else 0.0
    return o


def _bench(case: Case, seconds: float) -> tuple[Array, Array, Array, Array, Array]:
    """(t [s], handle x [m], load cell [N], desired force [N], (neglected [N], warned)) per tick, along one axis."""
    arm = Arm.mtm("right")
    plant, hand = arm.leader_options(), _core.HandOptions()
    leader = _core.Leader(arm, plant, hand)
    leader.reset(arm.home)
    model = arm.with_scaled_masses(np.full(arm.n, case.model_scale))
    torque = _core.Torque(_options(case, arm, plant), arm.tau_max, _DT)
    true_gravity = arm.gravity(arm.home) - model.gravity(arm.home)  # calibration corrects gravity of wrong masses

    w, K = 2 * np.pi * case.f_Hz, case.K_N_per_m
    A = min(HANDS[case.hand] / w, _FARTHEST, _FORCE * (1 / K + 1 / hand.stiffness))
    X0 = arm.fk(arm.home)
    n = round(seconds / _DT)
    rows = np.zeros((n, 6))
    F = np.zeros(6)
    for k in range(n):
        t = k * _DT
        q, cell = leader.q_measured, leader.F_cell_L
        x = float(arm.fk(q)[_AXIS, 3] - X0[_AXIS, 3])
        F[_AXIS] = -K * x
        command, status = torque.step(model, q, leader.v_measured, F, F_cell_L=cell)
        rows[k] = t, x, cell[_AXIS], F[_AXIS], command.F_neglected, bool(status & STATUS["too_fast"][0])
        gravity = command.tau_gravity + true_gravity
        leader.command(command.tau - command.tau_gravity - command.tau_platform, gravity, command.tau_platform)
        X, V = X0.copy(), np.zeros(6)
        X[_AXIS, 3] += A * np.sin(w * t)
        V[_AXIS] = A * w * np.cos(w * t)
        leader.step(_DT / _SUBSTEPS, X, V, n=_SUBSTEPS)
    return rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3], rows[:, 4:]


def bandwidth(found: list[Outcome], law: str, K: float, hand: str) -> float:
    """Frequency up to which the stiffness at the hand is within `NOTICED` of K, interpolated logarithmically [Hz].

    The result is 0 if the error is larger already at the lowest frequency.
    """
    rows = [o for o in found if (o.law, o.K_N_per_m, o.hand, o.model_scale) == (law, K, hand, 1.0)]
    rows.sort(key=lambda o: o.f_Hz)
    before: Outcome | None = None
    for after in rows:
        if after.stiffness_error > NOTICED:
            if before is None:
                return 0.0
            e0, e1 = np.log([before.stiffness_error, after.stiffness_error])
            share = (np.log(NOTICED) - e0) / (e1 - e0)
            return float(before.f_Hz * (after.f_Hz / before.f_Hz) ** share)
        before = after
    return before.f_Hz if before else 0.0


def table(found: list[Outcome]) -> Table:
    """Errors of the stiffness at the hand for the middle stiffness, and the bandwidths."""
    out = Table(
        box=None, pad_edge=False, title=f"felt spring: error at {MIDDLE:g} N/m; with friction", title_justify="left"
    )
    for column in ("law", "hand", *(f"{f:g} Hz" for f in FREQUENCIES), "10 % up to"):
        out.add_column(column, justify="left" if column in ("law", "hand") else "right")
    for law in LAWS:
        for hand in HANDS:
            mine = (law, MIDDLE, hand, 1.0)
            rows = {o.f_Hz: o for o in found if (o.law, o.K_N_per_m, o.hand, o.model_scale) == mine}
            errors = (
                f"{100 * rows[f].stiffness_error:.0f}; {100 * rows[f].impedance_error:.0f} %" if f in rows else ""
                for f in FREQUENCIES
            )
            out.add_row(law, hand, *errors, f"{bandwidth(found, law, MIDDLE, hand):.2g} Hz")
    return out
