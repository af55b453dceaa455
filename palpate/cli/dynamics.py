"""`palpate calibrate dynamics`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml
from rich.table import Table

from palpate.arm import NAMES, Arm
from palpate.cli.output import console_for, say, write_json, write_text
from palpate.errors import ArmError

if TYPE_CHECKING:
    from palpate.arm.dynamics import Dynamics as Model
    from palpate.cli.calibrate import Dynamics
    from palpate.identify.motion import Motion

CUTOFFS = (2.0, 3.0, 5.0, 10.0)  # at which a test is judged as well: what is left rises with the band [Hz]
_SHORT = {"mtm": "mtm_right", "mtml": "mtm_left", "mtmr": "mtm_right", "psm": "psm_lnd"}


def dynamics(command: Dynamics) -> int:
    """Identify, judge, write."""
    from palpate.arm.dynamics import to_data
    from palpate.errors import refuse_to_overwrite
    from palpate.identify import dynamics as identification

    console = console_for(command.json)
    refuse_to_overwrite(command.out, command.force)
    arm = arm_named(command.arm)
    started = time.perf_counter()
    train = [identification.read_motion(str(file), arm, command.rate, command.at) for file in command.train]
    test = None
    if command.test is not None:
        test = identification.read_motion(str(command.test), arm, command.rate, command.at)
    model = identification.identify(train, arm, command.cutoff, command.at)
    figures = _figures(model, train, test, time.perf_counter() - started)
    write_text(command.out, yaml.safe_dump(to_data(model), sort_keys=False))
    console.print(_table(figures, identification.PUBLISHED.get(arm.name.split("_")[0])))
    say(console, f"{model.cutoff:g} Hz, both sides, no phase: rms of the error over rms of the torque", "filtered at")
    say(
        console, f"{model.rank} of {len(model.pi)} inertial parameters, condition {model.condition:.3g}", "identifiable"
    )
    if model.unknown:
        say(console, ", ".join(model.unknown), "the motion says little about", "yellow")
    say(console, str(command.out), "model")
    write_json(command.json, figures)
    return 0


def arm_named(name: str) -> Arm:
    """An arm that comes with Palpate, also by a short name, or a model file.

    Raises:
        ArmError: there is no such arm.
    """
    name = _SHORT.get(name, name)
    if name not in NAMES and not Path(name).is_file():
        raise ArmError(f"there is no arm {name!r}", mend=f"use {', '.join((*_SHORT, *NAMES))}, or a model file")
    return Arm.model(name)


def _figures(model: Model, train: list[Motion], test: Motion | None, seconds: float) -> dict[str, Any]:
    from palpate.identify.dynamics import consistency, relative_rms

    cutoffs = [f for f in CUTOFFS if f < 0.5 * train[0].rate]
    return {
        "arm": model.arm.name,
        "recorded_at": model.at,
        "cutoff_Hz": model.cutoff,
        "train": {
            "relative_rms": [relative_rms(model, m).tolist() for m in train],
            "repeated_rows": [m.repeated for m in train],
        },
        "test": None
        if test is None
        else {
            "relative_rms": relative_rms(model, test).tolist(),
            "cutoffs_Hz": cutoffs,
            "relative_rms_at": relative_rms(model, test, *cutoffs).tolist(),
        },
        "rank": model.rank,
        "condition": model.condition,
        "unknown": list(model.unknown),
        "consistency": consistency(model).tolist(),
        "terms": {t.name: float(x) for t, x in zip(model.train.terms, model.theta, strict=True)},
        "seconds": seconds,
    }


def _table(figures: dict[str, Any], published: tuple[float, ...] | None) -> Table:
    table = Table(title=f"relative RMS of {figures['arm']}'s drive torques", title_justify="left")
    rows = [(f"train {k + 1}", row) for k, row in enumerate(figures["train"]["relative_rms"])]
    if figures["test"] is not None:
        rows.append(("test", figures["test"]["relative_rms"]))
        wider = zip(figures["test"]["cutoffs_Hz"], figures["test"]["relative_rms_at"], strict=True)
        rows += [(f"test, at {cutoff:g} Hz", row) for cutoff, row in wider if cutoff != figures["cutoff_Hz"]]
        if published is not None:
            rows.append(("published, on a test", list(published)))
    table.add_column("drive")
    for j in range(len(rows[0][1])):
        table.add_column(str(j + 1), justify="right")
    for name, row in rows:
        table.add_row(name, *(f"{x:.3f}" for x in row))
    return table
