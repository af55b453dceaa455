"""`palpate export moveit`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, make_folder, say, write_json


@dataclass
class Command:
    """Write the instrument and the objects of a scene as MoveIt 2 reads them: URDF, SRDF, limits, kinematics, scene.

    examples:
      palpate export moveit planning --out moveit
      palpate plan planning --trajectory trajectory.yaml

    The second command checks a trajectory of MoveIt (ros2 topic echo, RobotTrajectory or JointTrajectory).
    """

    scene: Positional[Path]
    """Scene file (YAML), or the name of a shipped scene."""
    out: Annotated[Path, arg(metavar="DIR")] = Path("moveit")
    """Folder for the files."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the names of the files as JSON (docs/json/plan.md); - for the standard output."""

    def __call__(self) -> int:
        """Write the files and name them."""
        from palpate.planning import Problem
        from palpate.planning.moveit import export
        from palpate.scene import Scene

        console = console_for(self.json)
        make_folder(self.out)
        problem = Problem.of(Scene.load(self.scene))
        files = export(problem, self.out)
        for file in files:
            say(console, str(file), "wrote")
        write_json(self.json, {"arm": problem.robot.name, "files": [str(file) for file in files]})
        return 0
