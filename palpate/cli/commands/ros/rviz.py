"""`palpate ros rviz`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say


@dataclass
class Command:
    """Write a configuration of RViz for `palpate ros haptics SCENE`: arms, frames, forces, objects and clouds.

    examples:
      palpate ros rviz my_two_hands.yaml --out two.rviz
      rviz2 -d two.rviz
    """

    scene: Positional[Path]
    """Scene file (YAML)."""
    out: Annotated[Path, arg(metavar="FILE.rviz")] = Path("palpate.rviz")
    """File to write."""
    leader: str = "MTMR"
    """CRTK name of the master, for a scene without pairs."""
    follower: str = "PSM1"
    """CRTK name of the patient-side arm, for a scene without pairs."""

    def __call__(self) -> int:
        """Write the file; returns the exit code."""
        import yaml

        from palpate.ros import rviz
        from palpate.ros.haptics import Devices
        from palpate.ros.pairs import devices_of
        from palpate.scene import Scene

        require_writable(self.out)
        scene = Scene.load(self.scene)
        contents = rviz.config(scene, devices_of(scene) or {"": Devices(self.leader, self.follower)})
        self.out.write_text(yaml.safe_dump(contents, sort_keys=False), encoding="utf-8")
        say(console_for(None), f"{self.out}, {len(rviz.topics(contents))} topics", "configuration:")
        return 0
