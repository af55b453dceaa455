"""`palpate register handeye`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, UseAppendAction, arg

from palpate.cli.commands.register import _common


@dataclass
class Command(_common.Register):
    """Find a camera on or beside an arm from views of a board (AX = XB, AX = ZB).

    examples:
      palpate register handeye arm.csv board.csv --mount arm --out X_EC.yaml

    A file has one row per pose: columns x, y, z, qw, qx, qy, qz, optionally t. The first holds the tool in the arm's
    base, the second the board in the camera, at the same instants.
    """

    arm: Positional[Path]
    """Poses of the tool in the arm's base (CSV)."""
    camera: Positional[Path]
    """Poses of the board in the camera (CSV)."""
    mount: Literal["arm", "beside"] = "arm"
    """Where the camera is: on the arm, or beside it with the board on the tool."""
    target: Annotated[UseAppendAction[tuple[str, ...]], arg(metavar="[NAME=]X,Y,Z")] = ()
    """Target in the camera's frame [m]; may be repeated."""

    def __call__(self) -> int:
        """Calibrate, print, write."""
        import numpy as np

        from palpate.world.registration import files, handeye

        console = self.begin()
        names, goals = _common.targets(self.target)
        found = handeye(
            files.read_poses(self.arm, self.unit), files.read_poses(self.camera, self.unit), self.mount, goals
        )
        values = _common.values_of("handeye", found, names)
        sigma = np.sqrt(np.diag(found.covariance))
        lines = [
            f"X, the camera in the {'tool' if self.mount == 'arm' else 'base'} frame:",
            *_common.lines_of_pose(values["X"]),
            f"predicted error: {1e3 * np.linalg.norm(sigma[:3]):.3f} mm and "
            f"{np.degrees(np.linalg.norm(sigma[3:])):.3f} deg rms",
            f"{len(found.residuals)} views, residual {1e3 * found.fre:.3f} mm and "
            f"{np.degrees(found.rotation_fre):.3f} deg rms",
            f"errors of one view and of the arm, estimated: {1e3 * found.fle:.3f} mm and "
            f"{np.degrees(found.rotation_fle):.3f} deg rms, {found.freedom} degrees of freedom",
            f"distances of the camera over those of the arm: {found.size:.4f} +- {found.size_deviation:.4f}",
            *_common.lines_of_wrong("view", found),
        ]  # fmt: skip
        self.finish(console, lines, values, (self.arm, self.camera))
        return 0
