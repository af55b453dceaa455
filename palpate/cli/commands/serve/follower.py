"""`palpate serve follower`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.cli.terminal import HOST

if TYPE_CHECKING:
    from palpate.ros.patient import RosPatient
    from palpate.scene.rig import Rig
    from palpate.session.network.video import VideoSource

_ROS = "ros:"  # before the topic of a camera


@dataclass
class Command:
    """Let an instrument, simulated or an arm over ROS 2, follow an operator across the network (docs/network.md).

    examples:
      palpate serve follower remote
      palpate serve follower my.yaml --host 192.168.1.7 --port 7410 --key link.key
      palpate serve follower my.yaml --arm PSM1 --force /PSM1/tissue_cf
      palpate serve follower two.yaml --arm PSM1 PSM2 --force /PSM1/tissue_cf /PSM2/tissue_cf

    The operator's end is `palpate run SCENE --remote HOST:PORT` with the same scene and the same key. Ctrl-C ends it.
    """

    scene: Positional[Path]
    """Scene file (YAML), or the name of a shipped scene."""
    port: int = 7410
    """Port of UDP and TCP; 0: any free one, which is printed."""
    host: str = HOST
    """Address on which it listens: 127.0.0.1 for this machine only."""
    key: Annotated[Path | None, arg(metavar="FILE")] = None
    """The shared key; default: that of `palpate keys`."""
    arm: Annotated[tuple[str, ...], arg(metavar="NAME")] = ()
    """Name of an arm over ROS 2 that follows by CRTK's servo_cp, such as PSM1, with the base of the scene's follower;
    one for each pair, in the order of the scene. A simulated instrument when left out."""
    force: Annotated[tuple[str, ...], arg(metavar="TOPIC")] = ()
    """With --arm: topic of the measured force of the tissue on its tool (WrenchStamped); one for each arm."""
    force_axes: Literal["base", "tip"] = "base"
    """With --arm: axes of that force, of the arm's base (as its measured_cp) or of its tip."""
    video: Annotated[str | None, arg(metavar="SOURCE")] = None
    """A camera that the operator sees in the viewer: ros:/camera/image_raw (sensor_msgs/Image or CompressedImage),
    http://... of motion JPEG, a folder of *.jpg files, or scene for the endoscope of a simulated site."""
    network: bool = False
    """With --arm or a camera over ROS 2: ROS 2 communicates with other machines; otherwise only within this one."""

    def __call__(self) -> int:
        """Serve until Ctrl-C; returns the exit code."""
        from rich.console import Console

        from palpate.base import stop_signals
        from palpate.cli.terminal.output import say
        from palpate.scene import Scene
        from palpate.scene.rig import build
        from palpate.scene.together import build_pairs
        from palpate.session.network.keys import default_path, read_key, require_cryptography
        from palpate.session.remote.site import FollowerServer

        require_cryptography()
        key, console = read_key(self.key or default_path()), Console()
        scene = Scene.load(self.scene)
        rigs = build_pairs(scene) if scene.pairs else {"": build(scene)}
        rate = scene.remote.rate if scene.remote is not None else 1000.0
        camera = self._camera(rigs, lambda: [one.packet() for one in server.followers if server.attended])
        arms = self._arms(rigs, lambda line: say(console, line))
        server = FollowerServer(rigs, key, self.host, self.port, rate, lambda line: say(console, line), arms,
                                camera)  # fmt: skip
        say(console, f"listening on {self.host} port {server.port}; Ctrl-C ends it")
        with stop_signals.deferred(server.stopped):
            server.run()
        counts = f"{server.ticks} ticks, {server.missed} missed, {server.sent} packets sent, {server.strangers} refused"
        if server.video is not None:
            say(console, f"{server.video.sent} pictures sent, {server.video.dropped} dropped")
        say(console, f"{counts}, largest force {server.largest:.2f} N, {server.cpu:.2f} s of processor time")
        return 0

    def _camera(self, rigs: Mapping[str, Rig], packets: Callable[[], list[bytes]]) -> VideoSource | None:
        """The source of the pictures that are sent to the operator."""
        from palpate.base.errors import PalpateError
        from palpate.session.network.video import source

        if self.video == "scene":
            if self.arm:
                raise PalpateError("--video scene: an arm over ROS 2 is at no simulated site",
                                   mend="give its camera, e.g. --video ros:/camera/image_raw")  # fmt: skip
            from palpate.gym.site_camera import SiteCamera

            return SiteCamera(list(rigs.values()), packets)
        if self.video is None or not self.video.startswith(_ROS):
            return None if self.video is None else source(self.video)
        from palpate.ros.pictures import RosPictures

        return RosPictures(self.video.removeprefix(_ROS), self.network)

    def _arms(self, rigs: Mapping[str, Rig], on_change: Callable[[str], None]) -> list[RosPatient]:
        """The arms over ROS 2, one of each pair; none for simulated instruments."""
        from palpate.base.errors import PalpateError

        names = " ".join(self.arm)
        if not self.arm:
            if self.force:
                raise PalpateError(f"--force {' '.join(self.force)}: a simulated instrument measures its own force",
                                   mend="name the arm as well: --arm PSM1")  # fmt: skip
            over_ros = self.video is not None and self.video.startswith(_ROS)
            if (self.network and not over_ros) or self.force_axes != "base":
                given = "--network" if self.force_axes == "base" else f"--force-axes {self.force_axes}"
                raise PalpateError(f"{given}: a simulated instrument does not use ROS 2",
                                   mend="name the arm as well: --arm PSM1; --host lets other machines in")  # fmt: skip
            return []
        if len(self.arm) != len(rigs) or len(set(self.arm)) != len(self.arm):
            pairs = " ".join(rigs) if len(rigs) > 1 else "one pair"
            raise PalpateError(f"--arm {names}: each pair of this scene needs an arm of its own",
                               why=f"it has {pairs}",
                               mend="give as many different arms, in this order, or leave --arm out")  # fmt: skip
        if len(self.force) != len(self.arm):
            raise PalpateError(f"--arm {names}: the force of the tissue on its tool is not known",
                               why="the site learns the tissue from it, and keeps it below 3 N",
                               mend="give the topic of each arm's force sensor: --force /NAME/measured_cf")  # fmt: skip
        from palpate.ros.patient import RosPatient

        made: list[RosPatient] = []
        try:
            for rig, name, force in zip(rigs.values(), self.arm, self.force, strict=True):
                made.append(RosPatient(rig, name, force, self.force_axes, self.network, on_change))
        except PalpateError:
            for one in made:
                one.stop()
            raise
        return made
