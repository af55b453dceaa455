"""``palpate study collisions``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from rich.console import Console
from tyro.conf import arg

from palpate_lab.studies._command import Findings, Study


@dataclass
class Command(Study):
    """The paper's Fig 5: which links of a moving instrument touch which mesh, where, how deep, and how fast.

    The meshes are an organ and a skeleton from an .nrrd segmentation. Contact and distance are compared with brute
    force on random poses.

    examples:
      palpate study collisions --json collisions.json
      palpate study collisions --volume segmentation.nrrd --label bone
    """

    volume: Annotated[Path | None, arg(metavar="FILE.nrrd")] = None
    """A segmentation instead of the generated skeleton."""
    label: str | None = None
    """Segment of the volume; not needed if it has one."""
    poses: int = 10_000
    """Random poses on which Coal is compared with brute force [-]."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from rich.table import Table

        from palpate.planning.geometry import require
        from palpate_lab.studies.collisions.figures import draw
        from palpate_lab.studies.collisions.work import STEPS, run, scene

        require()
        folder = self.folder
        result, found, world = run(folder, self.volume, self.label, self.poses)
        robot = scene(folder, self.volume, self.label)[0]
        table = Table("link", "mesh", "steps in contact", "points", "largest depth [mm]")
        for row in result["pairs"]:
            depth = f"{1e3 * row['largest_depth_m']:.2f}"
            table.add_row(row["link"], row["mesh"], str(row["steps"]), str(row["points"]), depth)
        brute = result["brute_force"]
        lines = [
            f"all {result['links']} links against both meshes: {1e3 * result['query_median_s']:.2f} ms (median)",
            f"{brute['poses']:,} random poses, {brute['touching']:,} in contact: {brute['disagreements']} "
            "disagreements with brute force, "
            f"distances differ by {1e6 * brute['worst_distance_error_m']:.2g} um at most",
        ]
        return Findings(result, lambda where: draw(where, robot, world, found, STEPS), [table, *lines])
