"""`palpate path`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Turn a recorded tool motion into a path file that a guidance fixture follows.

    examples:
      palpate path runs/demonstration/record.mcap --out suture.csv
      palpate path record.mcap --out cut.csv --start 2 --end 9.5 --smooth 0.5

    The path is resampled evenly along its length, so that pauses have no weight, then smoothed by a Gaussian and
    thinned. The command prints the deviation from the demonstration. Use in a scene: guidance: [follow: suture.csv].
    """

    record: Positional[Path]
    """Record (MCAP), or its folder."""
    out: Annotated[Path, arg(metavar="FILE.csv")] = Path("path.csv")
    """The path file to write: positions and orientations, with the unit in the header."""
    spacing: Annotated[float, arg(metavar="MM")] = 2.0
    """Distance of the path points."""
    smooth: Annotated[float, arg(metavar="MM")] = 1.0
    """Standard deviation of the Gaussian along the path; 0: no smoothing."""
    start: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Time in the record at which the demonstration begins."""
    end: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Time at which it ends."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Read the demonstration, write the path file, print the deviation."""
        from palpate.scene.guidance import curve, demonstration
        from palpate.scene.guidance.files import write_rows

        console, out = console_for(self.json), self.out
        spacing, smooth = 1e-3 * self.spacing, 1e-3 * self.smooth
        shown = demonstration.read(self.record, (self.start or 0.0, float("inf") if self.end is None else self.end))
        require_writable(out)
        places, rotations = demonstration.simplified(shown, spacing, smooth)
        path = curve.path(places, rotations, name=str(self.record), crossing=0.0)
        write_rows(out, places, rotations)
        off = demonstration.deviation(path, shown)
        say(console, f"{self.record}: {len(shown.t):,} ticks, {shown.t[-1] - shown.t[0]:.2f} s of motion")
        say(console, f"smoothed over {1e3 * smooth:g} mm, a point every {1e3 * spacing:g} mm: "
                     f"{len(places)} points, {1e3 * path.length:.4g} mm long")  # fmt: skip
        say(console, f"deviation from the demonstration: rms {1e3 * off.rms:.3g} mm, worst {1e3 * off.worst:.3g} mm")
        try:
            curve.path(places, rotations, name=str(out))
        except PalpateError as error:
            say(console, str(error), "warning:", "yellow")
        say(console, f"wrote {out}; in a scene: follow: {out}")
        write_json(self.json, {"record": str(self.record), "path": str(out), "places": len(places),
                               "length_m": path.length, "deviation_rms_m": off.rms,
                               "deviation_max_m": off.worst})  # fmt: skip
        return 0
