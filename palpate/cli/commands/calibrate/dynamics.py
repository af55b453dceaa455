"""`palpate calibrate dynamics`."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.base.errors import ArmError, refuse_to_overwrite
from palpate.cli.terminal.output import console_for, say, write_json, write_text

if TYPE_CHECKING:
    from rich.table import Table

    from palpate.arm import Arm
    from palpate.arm.drives import At
    from palpate.arm.dynamics import Dynamics
    from palpate.arm.identify.motion import RecordedMotion
    from palpate.base.arrays import Array

CUTOFFS = (2.0, 3.0, 5.0, 10.0)  # further cutoffs for the test error, which grows with the bandwidth [Hz]
_SHORT = {"mtm": "mtm_right", "mtml": "mtm_left", "mtmr": "mtm_right", "psm": "psm_lnd"}


@dataclass
class Command:
    """Identify the full dynamics of an arm from recorded motions: links, friction, rotors and springs.

    examples:
      palpate calibrate dynamics one.csv --arm mtm --out mtm.yaml --test two.csv
      palpate calibrate dynamics one.csv two.csv --arm psm --out psm.yaml --json fit.json

    A recording is an evenly sampled CSV with q, dq and tau of all drives or all joints (rad, rad/s, N m);
    docs/dynamics.md lists the drives. The masses and inertias found are physically consistent. The model file serves
    to identify a payload (palpate.arm.identify.payload) and to estimate the tool force in a session (force.dynamics).
    """

    train: Positional[tuple[Path, ...]]
    """Recordings of motions for the fit (CSV)."""
    arm: str
    """Which arm was recorded: mtm, mtml, mtmr, psm, or a model file."""
    out: Annotated[Path, arg(metavar="MODEL.yaml")]
    """The model file to write."""
    test: Annotated[Path | None, arg(metavar="OTHER.csv")] = None
    """Recording of another motion that tests the model."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    at: Literal["drives", "joints"] = "drives"
    """Where the columns were measured: drives as in the published recordings, or joints as on ROS."""
    rate: float = 200.0
    """Sampling rate of the recordings [Hz]."""
    cutoff: float = 2.0
    """Cutoff of the low-pass filter on both measured and predicted torque [Hz]."""
    force: bool = False
    """Overwrite an existing file."""

    def __call__(self) -> int:
        """Identify the model, print its errors, write the model file and the JSON."""
        import yaml

        from palpate.arm.dynamics import to_data
        from palpate.arm.identify import dynamics as identification

        console = console_for(self.json)
        refuse_to_overwrite(self.out, self.force)
        arm = arm_named(self.arm)
        started = time.perf_counter()
        train = [identification.read_motion(str(file), arm, self.rate, self.at) for file in self.train]
        test = None
        if self.test is not None:
            test = identification.read_motion(str(self.test), arm, self.rate, self.at)
        model = identification.identify(train, arm, self.cutoff, self.at)
        figures = _figures(model, train, test, time.perf_counter() - started)
        write_text(self.out, yaml.safe_dump(to_data(model), sort_keys=False))
        console.print(_table(figures, identification.PUBLISHED.get(arm.name.split("_")[0])))
        say(
            console,
            f"zero-phase low-pass of {model.cutoff:g} Hz on measured and predicted torque; values are rms error over "
            "rms torque",
            "filter:",
        )
        say(
            console,
            f"{model.rank} of {len(model.pi)} inertial parameters, condition {model.condition:.3g}",
            "identifiable:",
        )
        if model.unknown:
            say(console, ", ".join(model.unknown), "not told apart by these motions, so the prior decided:", "yellow")
        console.print(_terms(model))
        if model.misfit.max() > identification.MISFIT:
            say(
                console,
                f"the model leaves {model.misfit.max():.2g} times the noise of the torque (drive "
                f"{int(model.misfit.argmax()) + 1}): the arm has friction or springs of another form, and the "
                "intervals do not cover that",
                "warning:",
                "yellow",
            )
        say(console, str(self.out), "model:")
        write_json(self.json, figures)
        return 0


def arm_named(name: str) -> Arm:
    """The arm of a name, a short name, or a model file.

    Raises:
        ArmError: no arm has this name.
    """
    from palpate.arm import NAMES, Arm

    name = _SHORT.get(name, name)
    if name not in NAMES and not Path(name).is_file():
        raise ArmError(f"there is no arm {name!r}", mend=f"use {', '.join((*_SHORT, *NAMES))}, or a model file")
    return Arm.model(name)


@dataclass(frozen=True)
class TrainErrors:
    """Errors on the recordings of the fit."""

    relative_rms: list[Array]  # per recording: rms error over rms torque of each drive
    repeated_rows: list[int]  # per recording


@dataclass(frozen=True)
class TestErrors:
    """Errors on the recording of another motion."""

    relative_rms: Array  # (drives,)
    cutoffs_Hz: list[float]
    relative_rms_at: Array  # (cutoffs, drives)


@dataclass(frozen=True)
class Figures:
    """Figures of the identified dynamics: the documented contract of ``--json`` (docs/json.md)."""

    arm: str
    recorded_at: At
    cutoff_Hz: float
    train: TrainErrors
    test: TestErrors | None
    rank: int
    condition: float
    unknown: tuple[str, ...]
    consistency: Array
    terms: dict[str, float]
    terms_95: dict[str, Array]
    misfit: Array
    seconds: float


def _figures(model: Dynamics, train: list[RecordedMotion], test: RecordedMotion | None, seconds: float) -> Figures:
    from palpate.arm.identify.dynamics import consistency, relative_rms

    cutoffs = [f for f in CUTOFFS if f < 0.5 * train[0].rate]
    return Figures(
        arm=model.arm.name,
        recorded_at=model.at,
        cutoff_Hz=model.cutoff,
        train=TrainErrors([relative_rms(model, m) for m in train], [m.repeated for m in train]),
        test=TestErrors(relative_rms(model, test), cutoffs, relative_rms(model, test, *cutoffs))
        if test is not None
        else None,
        rank=model.rank,
        condition=model.condition,
        unknown=model.unknown,
        consistency=consistency(model),
        terms={t.name: float(x) for t, x in zip(model.train.terms, model.theta, strict=True)},
        misfit=model.misfit,
        terms_95=dict(zip((t.name for t in model.train.terms), model.intervals(), strict=True)),
        seconds=seconds,
    )


def _terms(model: Dynamics) -> Table:
    """The drive train's terms with their intervals."""
    from rich.table import Table

    table = Table(title="drive train, 95 % intervals [N m, N m s/rad, kg m^2; N, N s/m, kg]", title_justify="left")
    for head in ("term", "value", "low", "high"):
        table.add_column(head, justify="left" if head == "term" else "right")
    for term, value, (low, high) in zip(model.train.terms, model.theta, model.intervals(), strict=True):
        table.add_row(term.name, f"{value:.3g}", f"{low:.3g}", f"{high:.3g}")
    return table


def _table(figures: Figures, published: tuple[float, ...] | None) -> Table:
    from rich.table import Table

    table = Table(title=f"relative RMS of {figures.arm}'s drive torques", title_justify="left")
    rows = [(f"train {k + 1}", row.tolist()) for k, row in enumerate(figures.train.relative_rms)]
    if figures.test is not None:
        rows.append(("test", figures.test.relative_rms.tolist()))
        wider = zip(figures.test.cutoffs_Hz, figures.test.relative_rms_at.tolist(), strict=True)
        rows += [(f"test, at {cutoff:g} Hz", row) for cutoff, row in wider if cutoff != figures.cutoff_Hz]
        if published is not None:
            rows.append(("published, on a test", list(published)))
    table.add_column("drive")
    for j in range(len(rows[0][1])):
        table.add_column(str(j + 1), justify="right")
    for name, row in rows:
        table.add_row(name, *(f"{x:.3f}" for x in row))
    return table
