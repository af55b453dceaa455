"""`palpate ros camera`."""

from __future__ import annotations

import sys
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, say


@dataclass
class Command:
    """Publish the simulated depth camera of a scene on ROS 2: cloud, depth image, camera_info and its frame.

    examples:
      palpate ros camera scenes/camera.yaml
      palpate ros camera scenes/camera.yaml --sensor camera --prefix /kinect

    The objects move as the scene says; the instrument rests at its start. Ctrl-C ends it.
    """

    scene: Positional[Path]
    """Scene file (YAML) with a section sensors."""
    sensor: str = ""
    """Name of the camera; the first simulated one when left out."""
    prefix: str = "/camera"
    """First part of the topics."""
    duration: float | None = None
    """End after this time [s]."""
    network: bool = False
    """Communicate with other machines; otherwise only within this one."""

    def __call__(self) -> int:
        """Publish until the duration or Ctrl-C."""
        from palpate.ros.camera import CameraNode
        from palpate.scene import Scene

        if self.duration is not None and not 0.0 < self.duration < 1e7:
            raise PalpateError(f"--duration {self.duration:g}: must be above 0 s", mend="give e.g. --duration 60")
        console = console_for(None)
        node = CameraNode(Scene.load(self.scene), self.sensor, self.prefix, self.network)
        say(console, f"camera {node.name!r} at {node.rate:g} Hz on {node.topic}, in the frame {node.frame}")
        say(console, "Ctrl-C ends it")
        sys.stdout.flush()
        try:
            with suppress(KeyboardInterrupt):
                node.run(self.duration)
        finally:
            node.close()
        say(console, f"ended after {node.frames} frames")
        return 0
