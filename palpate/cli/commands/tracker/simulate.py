"""`palpate tracker simulate`."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rich.console import Console
from tyro.conf import Positional, arg

from palpate.cli.terminal.output import say

if TYPE_CHECKING:
    from palpate.scene import Scene


@dataclass
class Command:
    """Serve the simulated tracker of a scene over OpenIGTLink, for 3D Slicer or another palpate run.

    examples:
      palpate tracker simulate scenes/tracked.yaml
      palpate tracker simulate scenes/tracked.yaml --port 18945 --duration 60

    Poses, noise, dropouts and faults are those of the scene's section trackers; time begins with the command. A scene
    that reads this server gives its tracker openigtlink: 127.0.0.1:18944. The server binds to this machine (127.0.0.1)
    and serves one client at a time.
    """

    scene: Positional[Path]
    """Scene file (YAML) with a simulated tracker."""
    tracker: str | None = None
    """Name of the tracker; the only simulated one when left out."""
    port: int = 18944
    """Port on 127.0.0.1."""
    duration: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Time to serve [s]; until Ctrl-C when left out."""

    def __call__(self) -> int:
        """Serve until the end of the duration or Ctrl-C."""
        from palpate.scene import Scene
        from palpate.scene.rig import build
        from palpate.sensing.trackers.openigtlink import OpenIGTLinkServer
        from palpate.sensing.trackers.tracking import simulated

        scene = Scene.load(self.scene)
        name = self._name(scene)
        source = simulated(build(scene), name)
        tools = ", ".join(one.tool or one.child for one in scene.frames if one.tracker == name) or "no tools"
        with OpenIGTLinkServer(self.port) as server:
            say(Console(highlight=False), f"tracker {name!r} on 127.0.0.1:{server.port}: {tools} (Ctrl-C ends it)")
            began, epoch = time.monotonic(), time.time()
            while self.duration is None or time.monotonic() - began < self.duration:
                for seen in source.poll(time.monotonic() - began):
                    server.send(seen.at(epoch + seen.t))
                time.sleep(0.005)
        return 0

    def _name(self, scene: Scene) -> str:
        from palpate.base.errors import SceneError

        names = [name for name, one in scene.trackers.items() if one.simulated is not None]
        if self.tracker is not None or len(names) == 1:
            name = self.tracker or names[0]
            if name in names:
                return name
            what = f"there is no simulated tracker {name!r}"
        else:
            what = f"the scene has {len(names)} simulated trackers"
        mend = f"give --tracker, one of {', '.join(names)}" if names else "give trackers: {polaris: {simulated: {}}}"
        raise SceneError(what, where=scene.where("trackers"), mend=mend)
