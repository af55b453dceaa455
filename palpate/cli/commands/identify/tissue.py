"""`palpate identify tissue`."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from palpate.base.errors import refuse_to_overwrite
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.table import Table

    from palpate.arm.identify.tissue import TissueFit


@dataclass
class Command:
    """Identify modulus, stiffening and relaxation of tissue from a recorded press by a sphere.

    examples:
      palpate identify tissue press.csv --radius 4
      palpate identify tissue runs/soft_liver-*/record.mcap --radius 6 --thickness 40 --json tissue.json

    A CSV has columns time_s, depth_mm and force_N (or time_ms, depth_m, depth_um, force_mN, force_uN). Press fast, then
    hold the depth: the press shows modulus and stiffening, the hold shows relaxation.
    """

    recording: Positional[Path]
    """CSV, or record (MCAP) of a session."""
    radius: Annotated[float, arg(metavar="MM")]
    """Radius of the sphere."""
    thickness: Annotated[float | None, arg(metavar="MM")] = None
    """Thickness of the tissue on a rigid ground; thick when left out."""
    poisson: Annotated[float, arg(metavar="NU")] = 0.45
    """Poisson's ratio, which the press does not show."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    figure: Annotated[Path | None, arg(metavar="FILE.png")] = None
    """Draw the measured and the fitted force."""
    force: bool = False
    """Overwrite existing files."""

    def __call__(self) -> int:
        """Fit the tissue, print it, and write the JSON and the figure."""
        import numpy as np

        from palpate.arm.identify import press_recording, tissue
        from palpate.base.errors import MissingExtraError, RecordingError

        console = console_for(self.json)
        if self.figure is not None:
            refuse_to_overwrite(self.figure, self.force)
            if importlib.util.find_spec("matplotlib") is None:
                raise MissingExtraError("the figure", "report")
        require_writable(self.json)
        if not 0.0 <= self.poisson <= 0.5 or (self.thickness is not None and not self.thickness > 0.0):
            what = (
                f"--poisson {self.poisson:g}" if not 0.0 <= self.poisson <= 0.5 else f"--thickness {self.thickness:g}"
            )
            raise RecordingError(f"{what} is impossible", mend="--poisson from 0 to 0.5, --thickness above 0")
        press = press_recording.load(self.recording)
        thickness = np.inf if self.thickness is None else 1e-3 * self.thickness
        found = tissue.fit(press, 1e-3 * self.radius, thickness, self.poisson)
        console.print(_table(found))
        for sentence in found.not_identifiable:
            say(console, sentence, "not identified:", "yellow")
        say(console, f"in a scene: {_scene_words(found)}")
        if self.figure is not None:
            from palpate.arm.identify.tissue_figure import save

            save(found, self.figure)
            say(console, f"figure: {self.figure}")
        write_json(self.json, figures(found))
        return 0


def figures(found: TissueFit) -> dict[str, Any]:
    """The figures for JSON, as docs/json/identify.md describes them."""
    from palpate.base.arrays.checks import finite_or_none

    return {
        "young_Pa": found.young,
        "young_Pa_95": list(found.young_95),
        "instantaneous_Pa": found.instantaneous,
        "instantaneous_Pa_95": list(found.instantaneous_95),
        "stiffening": found.beta,
        "stiffening_95": [finite_or_none(x) for x in found.beta_95],
        "yeoh": found.yeoh,
        "prony": [{"g": g, "tau_s": tau} for g, tau in found.prony],
        "poisson": found.poisson,
        "radius_mm": 1e3 * found.radius,
        "thickness_mm": finite_or_none(1e3 * found.thickness),
        "touch_mm": 1e3 * found.touch,
        "offset_N": found.offset,
        "drift_N": found.drift,
        "residual": found.residual,
        "coloured": found.coloured,
        "deepest_radii": found.deepest,
        "seconds": found.seconds,
        "not_identifiable": list(found.not_identifiable),
    }


def _table(found: TissueFit) -> Table:
    from rich.table import Table

    table = Table(title="the tissue", title_justify="left", box=None)
    for head in ("", "value", "95 % confidence (noise)"):
        table.add_column(head, justify="left" if not head else "right")
    for name, E, (low, high) in (
        ("Young's modulus at rest", found.young, found.young_95),
        ("before relaxation", found.instantaneous, found.instantaneous_95),
    ):
        table.add_row(name, f"{1e-3 * E:.4g} kPa", f"{1e-3 * low:.4g} to {1e-3 * high:.4g}")
    low, high = found.beta_95
    interval = f"{100 * low:.3g} to {100 * high:.3g}" if high < float("inf") else "not identified"
    table.add_row("stiffening at one radius", f"{100 * found.beta:.3g} %", interval)
    for g, tau in found.prony:
        table.add_row(f"relaxing with {tau:.2g} s", f"{100 * g:.3g} % of the modulus at rest", "")
    table.add_row("residual", f"{100 * found.residual:.2g} % of the largest force", "")
    return table


def _scene_words(found: TissueFit) -> str:
    prony = ", ".join(f"{{g: {g:.3g}, tau: {tau:.3g}}}" for g, tau in found.prony if g > 0.005)
    keys = f"young: {found.young:.4g}, poisson: {min(found.poisson, 0.495):g}, yeoh: {found.yeoh:.2g}"
    return f"tissue: {{{keys}, prony: [{prony}]}}"
