"""`palpate calibrate gravity`."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.base.errors import refuse_to_overwrite
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.table import Table

    from palpate.arm.identify.gravity import Calibration


@dataclass
class Command:
    """Identify the gravity model of an arm from static poses: masses, springs, cables and dry friction.

    examples:
      palpate calibrate gravity poses.csv --arm mtmr --out my_mtmr.yaml
      palpate calibrate gravity up.csv down.csv --arm mtml --out mtml.yaml --test others.csv --json fit.json

    A recording is a CSV of q1_rad .. q7_rad, tau1_Nm .. tau7_Nm at the joints, one row per pose in the order of
    visits. The command also draws MODEL.png. Use in a scene: arms: {leader: {gravity_model: MODEL.yaml}}.
    """

    train: Positional[tuple[Path, ...]]
    """Recordings for the fit (CSV); two files of the same poses, approached from opposite sides, are averaged."""
    arm: Literal["mtml", "mtmr"]
    """Which arm was recorded."""
    out: Annotated[Path, arg(metavar="MODEL.yaml")]
    """The model file to write."""
    model: Literal["potential", "dvrk", "gravity+springs", "paper"] = "potential"
    """Form of the model: Palpate's (potential), the dVRK's, or the paper's with or without springs."""
    test: Annotated[Path | None, arg(metavar="TEST.csv")] = None
    """Recording of other poses that tests the model."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    force: bool = False
    """Overwrite existing files."""

    def __call__(self) -> int:
        """Fit, report, write the model, its figure and the JSON."""
        from palpate.arm.identify.gravity import gravity, named_arm
        from palpate.arm.identify.gravity_figures import figures

        console = console_for(self.json)
        picture = self.out.with_suffix(".png")
        written = [self.out, picture, *([self.json] if self.json and str(self.json) != "-" else [])]
        for path in written:
            refuse_to_overwrite(path, self.force)
        require_writable(self.json)
        found = gravity(self.train, self.arm, model=self.model, test=self.test)
        found.model.save(self.out, self.force)
        console.print(_table(found))
        for line in _lines(found):
            say(console, line)
        for warning in found.warnings:
            say(console, warning, "warning:", "yellow")
        if importlib.util.find_spec("matplotlib") is not None:
            from palpate.arm.identify.figure import save

            save(found, named_arm(self.arm), picture)
            say(console, f"figure: {picture}")
        say(console, f"model: {self.out}")
        write_json(self.json, figures(found))
        return 0


def _table(c: Calibration) -> Table:
    from rich.table import Table

    table = Table(title=f"gravity of {c.model.arm}: {c.model.form}, {len(c.poses)} poses", title_justify="left")
    for head in ("joint", "train RMS", "R2", "test RMS", "R2", "friction floor", "approach known", "R2", "confidence"):
        table.add_column(head, justify="right")
    for i, joint in enumerate(c.joints):
        judged, test = c.test or c.train, c.test
        table.add_row(
            str(joint + 1), f"{c.train.rms[i]:.4f}", f"{c.train.r2[i]:.3f}",
            f"{test.rms[i]:.4f}" if test else "", f"{test.r2[i]:.3f}" if test else "",
            f"{judged.floor[i]:.4f}", f"{judged.rms_directed[i]:.4f}", f"{judged.r2_directed[i]:.3f}",
            f"+-{judged.std[i]:.4f}",
        )  # fmt: skip
    table.caption = (
        "All in N m. Friction floor: error that dry friction causes while the direction of approach is unknown. "
        "Approach known: RMS with the direction taken from the order of the rows. Confidence: standard deviation of "
        "the holding torque."
    )
    return table


def _lines(c: Calibration) -> list[str]:
    found, friction = c.identifiability, c.model.friction
    lines = [
        f"rank {found.rank} of {found.structural_rank} base parameters, condition {found.condition:.1f}",
        f"base parameters (the JSON defines each): {', '.join(b.split()[0] for b in found.base)}",
        f"not identifiable, as they never load these joints: {', '.join(found.never)}",
    ]
    if friction.any():
        of = "motors" if c.model.motor_friction else "joints"
        torques = ", ".join(f"{abs(x[0]):.4f}" for x in friction[: len(c.joints)])
        lines.append(f"dry friction of the {of} [N m]: {torques}")
    if c.pairs:
        lines.append(f"{len(c.pairs.half_difference)} poses approached from both sides: fitted to their means")
    if c.fitted.outliers:
        some = "; ".join(f"pose {o.pose + 1} joint {o.joint + 1}: {o.why}" for o in c.fitted.outliers[:3])
        lines.append(
            f"{len(c.fitted.outliers)} outliers excluded ({some}{' ..' if len(c.fitted.outliers) > 3 else ''})"
        )
    for q, gain in c.advice[:3]:
        lines.append(f"next pose [rad]: {' '.join(f'{x:+.2f}' for x in q)}   information gain {gain:.2f} nat")
    lines.append(f"computed in {c.seconds:.1f} s on one core")
    return lines
