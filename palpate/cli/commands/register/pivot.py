"""`palpate register pivot`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from palpate.cli.commands.register import _common


@dataclass
class Command(_common.Register):
    """Find the tip of a tool from its poses while the tip rests at one point (pivot calibration).

    examples:
      palpate register pivot poses.csv --out tip.yaml

    The file holds the tool in the tracker's frame: columns x, y, z, qw, qx, qy, qz, optionally t; or a table of
    OptiTrack Motive, NDI ToolBox or TUM.
    """

    poses: Positional[Path]
    """Poses of the tool (CSV)."""

    def __call__(self) -> int:
        """Calibrate, print, write."""
        from palpate.world.registration import files, pivot

        console = self.begin()
        found = pivot(files.read_poses(self.poses, self.unit))
        values = _common.values_of("pivot", found)
        tip = ", ".join(f"{1e3 * x:+.3f}" for x in found.p_TQ)
        lines = [
            f"tip at ({tip}) mm of the tool frame, predicted error {1e3 * found.tre:.3f} mm rms",
            f"{len(found.residuals)} poses, residual {1e3 * found.fre:.3f} mm rms",
            *_common.lines_of_wrong("pose", found),
        ]
        self.finish(console, lines, values, (self.poses,))
        return 0
