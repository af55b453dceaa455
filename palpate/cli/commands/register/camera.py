"""`palpate register camera`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, UseAppendAction, arg

from palpate.cli.commands.register import _common


@dataclass
class Command(_common.Register):
    """Find a camera beside an arm from the tool tip seen in its cloud; the tip's offset is found, too.

    examples:
      palpate register camera psm.csv tip_in_cloud.csv --target port=0,0,0.1 --out X_BC.yaml

    The first file holds the tool in the arm's base (x, y, z, qw, qx, qy, qz), the second the same point of the tool in
    the camera (x, y, z), row by row. Targets are in the camera's frame.
    """

    arm: Positional[Path]
    """Poses of the tool in the arm's base (CSV)."""
    seen: Positional[Path]
    """Tip in the camera (CSV)."""
    target: Annotated[UseAppendAction[tuple[str, ...]], arg(metavar="[NAME=]X,Y,Z")] = ()
    """Target in the camera's frame [m]; may be repeated."""

    def __call__(self) -> int:
        """Register, print, write."""
        from palpate.world.registration import camera, files

        console = self.begin()
        names, goals = _common.targets(self.target)
        found = camera(files.read_poses(self.arm, self.unit), files.read_points(self.seen, self.unit).p, goals)
        values = _common.values_of("camera", found, names)
        offset = ", ".join(f"{1e3 * x:+.2f}" for x in found.p_TQ)
        lines = [
            "X, the camera in the arm's base:", *_common.lines_of_pose(values["X"]),
            f"seen point of the tool at ({offset}) mm of the tool frame",
            f"FRE {1e3 * found.fre:.3f} mm rms; FLE {1e3 * found.fle:.3f} mm rms, estimated from the residuals",
            *_common.lines_of_wrong("point", found),
        ]  # fmt: skip
        self.finish(console, lines, values, (self.arm, self.seen))
        return 0
