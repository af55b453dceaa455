"""`palpate register surface`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, UseAppendAction, arg

from palpate.cli.commands.register import _common
from palpate.cli.terminal.output import say


@dataclass
class Command(_common.Register):
    """Register a partial cloud with a surface, from a rough pose or none, and say whether the answer can be trusted.

    examples:
      palpate register surface camera.pcd liver.stl --fixed-unit mm --out X_OC.yaml
      palpate register surface second.pcd first.pcd --voxel 0.02 --overlap 0.6 --start-identity
      palpate register surface phantom.pcd phantom.stl --out X.yaml --accept "training on a phantom, A. Meyer"

    Clouds: .csv, .npy, .pcd; surfaces also .stl, .ply, .obj. Returns 1 and writes no pose if the answer is not trusted
    and not accepted by a reason.
    """

    moving: Positional[Path]
    """Partial cloud."""
    fixed: Positional[Path]
    """Surface: a mesh or a dense cloud."""
    target: Annotated[UseAppendAction[tuple[str, ...]], arg(metavar="[NAME=]X,Y,Z")] = ()
    """Target in the moving frame [m]; may be repeated."""
    start: Annotated[Path | None, arg(metavar="POSE.yaml")] = None
    """Rough pose as written by --out; default: none, the whole surface is searched."""
    start_identity: bool = False
    """The rough pose is the identity: both clouds are nearly in place."""
    overlap: float = 0.85
    """Share of the moving points that must lie on the surface in a trusted answer."""
    noise: float | None = None
    """Standard deviation of distances along the normal [m]; default: estimated from the clouds."""
    voxel: float | None = None
    """Average both clouds over cells of this size first [m]."""
    accept: Annotated[str, arg(metavar="REASON")] = ""
    """Write the pose although it is not trusted; the reason is kept in its file with the doubts."""
    fixed_unit: Literal["m", "mm"] | None = None
    """Unit of the surface; default: --unit."""

    def __call__(self) -> int:
        """Register, judge, print, write."""
        import numpy as np

        from palpate.world.frames.files import pose
        from palpate.world.registration import surface
        from palpate.world.registration.cloud_files import averaged, read_cloud

        console = self.begin()
        names, goals = _common.targets(self.target)
        clouds = [read_cloud(self.moving, self.unit), read_cloud(self.fixed, self.fixed_unit or self.unit)]
        if self.voxel is not None:
            clouds = [averaged(cloud, self.voxel) for cloud in clouds]
        start = np.eye(4) if self.start_identity else None
        if self.start is not None:
            start = pose(self.start)
        found = surface(clouds[0], clouds[1], start, goals, noise=self.noise, overlap=self.overlap)
        values = _common.values_of("surface", found, names)
        lines = [
            "X, fixed = X moving:", *_common.lines_of_pose(values["X"]),
            f"{100 * found.explained:.0f} % of {len(clouds[0])} points lie on the surface, {1e3 * found.fre:.2f} mm rms"
            f"; noise of the clouds {1e3 * found.fle:.2f} mm",
        ]  # fmt: skip
        if self.accept and not found.trusted:
            values["accepted"] = self.accept
        elif not found.trusted:
            self.out = None
        self.finish(console, lines, values, (self.moving, self.fixed))
        for doubt in found.doubts:
            say(console, doubt, "not trusted:", "red")
        if "accepted" in values:
            say(console, f"in spite of this: {self.accept}", "accepted:", "yellow")
        return int(not found.trusted and "accepted" not in values)
