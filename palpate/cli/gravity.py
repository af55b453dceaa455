"""`palpate calibrate gravity`, `import`, `export`."""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING

from rich.table import Table

from palpate.arm import dvrk_gravity as dvrk
from palpate.arm.gravity_model import GravityModel
from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.errors import refuse_to_overwrite
from palpate.identify.gravity import Calibration, named_arm
from palpate.identify.gravity import gravity as identify

if TYPE_CHECKING:
    from palpate.cli.calibrate import Export, Gravity, Import


def gravity(o: Gravity) -> int:
    """Fit, tell, write the model, its figure and the JSON."""
    console = console_for(o.json)
    picture = o.out.with_suffix(".png")
    written = [o.out, picture, *([o.json] if o.json and str(o.json) != "-" else [])]
    for path in written:
        refuse_to_overwrite(path, o.force)
    require_writable(o.json)
    found = identify(o.train, o.arm, model=o.model, test=o.test)
    found.model.save(o.out, o.force)
    console.print(_table(found))
    for line in _lines(found):
        say(console, line)
    for warning in found.warnings:
        say(console, warning, "warning:", "yellow")
    if importlib.util.find_spec("matplotlib") is not None:
        from palpate.identify.figure import save

        save(found, named_arm(o.arm), picture)
        say(console, f"figure: {picture}")
    say(console, f"model: {o.out}")
    write_json(o.json, found.to_json())
    return 0


def import_dvrk(o: Import) -> int:
    """JSON of the dVRK to MODEL.yaml."""
    model = dvrk.load(o.file)
    model.save(o.out, o.force)
    say(console_for(None), f"model: {o.out}   ({model.arm}, serial {model.notes['serial'] or 'unknown'})")
    return 0


def export_dvrk(o: Export) -> int:
    """MODEL.yaml to JSON of the dVRK."""
    lost = dvrk.save(GravityModel.load(o.file), o.out, o.serial, o.force)
    say(console_for(None), f"written: {o.out}   its form loses " + ", ".join(f"{x:.4f}" for x in lost) + " N m (rms)")
    return 0


def _table(c: Calibration) -> Table:
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
        "N m. Friction floor: what dry friction leaves when nobody says from which side the arm came; approach known: "
        "the order of the rows says it. Confidence: standard deviation of the holding torque."
    )
    return table


def _lines(c: Calibration) -> list[str]:
    told, rub = c.told, c.model.friction
    lines = [
        f"rank {told.rank} of {told.structural_rank} base parameters, condition {told.condition:.1f}",
        f"base parameters (the JSON says what each stands for): {', '.join(b.split()[0] for b in told.base)}",
        f"not identifiable, never seen by these joints: {', '.join(told.never)}",
    ]
    if rub.any():
        of = "motors" if c.model.motor_friction else "joints"
        lines.append(f"dry friction of the {of} [N m]: " + ", ".join(f"{abs(x[0]):.4f}" for x in rub[: len(c.joints)]))
    if c.pairs:
        lines.append(f"{len(c.pairs.half_difference)} poses reached both ways: fitted to their means")
    if c.fitted.outliers:
        some = "; ".join(f"pose {o.pose + 1} joint {o.joint + 1}: {o.why}" for o in c.fitted.outliers[:3])
        lines.append(
            f"{len(c.fitted.outliers)} outliers kept out ({some}{' ..' if len(c.fitted.outliers) > 3 else ''})"
        )
    for q, gain in c.advice[:3]:
        lines.append(f"next pose [rad]: {' '.join(f'{x:+.2f}' for x in q)}   adds {gain:.2f} nat")
    lines.append(f"{c.seconds:.1f} s of one core")
    return lines
