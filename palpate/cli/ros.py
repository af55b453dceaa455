"""`palpate ros COMMAND`: what runs on ROS 2."""

from __future__ import annotations

import signal
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg

from palpate.cli.output import console_for, say


@dataclass
class Setup:
    """Find ROS 2 and compile what runs on it, once; says what is used and where it is kept.

    examples:
      palpate ros setup
      source /opt/ros/jazzy/setup.bash && palpate ros setup

    A sourced ROS 2 wins over the wheels of palpate[ros]. The other commands do the same on their first use.
    """

    def __call__(self) -> int:
        """Do it."""
        from palpate.ros import build, where

        console = console_for(None)
        say(console, where.find().words)
        built = build.build(lambda text: say(console, text))
        for name, prefix in built.messages.items():
            say(console, f"{name}: {'our definitions' if built.ours(name) else 'of ROS 2'}, {prefix}")
        say(console, f"nodes: {built.extension}")
        say(console, f"compiled in {built.seconds:.0f} s" if built.seconds else "all of it was there")
        return 0


@dataclass
class Sim:
    """A dVRK one can talk to: simulated arms, console, pedals and teleoperations under the real one's names.

    examples:
      palpate ros sim
      palpate ros sim --arms MTMR PSM1 --rate 1000
      ros2 topic pub --once /MTMR/state_command crtk_msgs/msg/StringStamped "{string: home}"

    The MTMs move by their dynamics: they yield to servo_cf, and fall when gravity compensation is off. Ctrl-C ends it.
    """

    arms: tuple[str, ...] = ("MTMR", "MTML", "PSM1", "PSM2", "ECM")
    """Of MTMR, MTML, PSM1, PSM2, PSM3, ECM; MTMR_PSM1 and MTML_PSM2 are teleoperated where both are there."""
    rate: Annotated[float, arg(metavar="HZ")] = 100.0
    """Of what the arms measure, 1 to 1000 [Hz]."""
    network: bool = False
    """Other machines may talk to it; otherwise this one alone."""
    meter: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Every so often a line with the rate that is reached, late servo ticks, commands and cores [s]."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.ros import sim

        console = console_for(None)
        robot = sim.start(self.arms, rate=self.rate, network=self.network, on_progress=lambda text: say(console, text))
        reach = "open to the network" if self.network else "this machine alone"
        try:
            say(console, f"simulated dVRK: {', '.join(self.arms)}; {robot.rate:g} Hz, {reach}, {robot.scheduler}")
            say(console, "Ctrl-C ends it")
            sys.stdout.flush()
            meter = sim.Meter(robot)
            while True:
                time.sleep(self.meter or 0.2)
                if self.meter:
                    now = meter.look()
                    words = f"{now['missed']:.0f} servo ticks late, {now['commands']:.0f} commands"
                    say(console, f"{now['rate']:.0f} Hz, {words}, {now['cores']:.2f} cores")
                    sys.stdout.flush()
        except KeyboardInterrupt:
            for end in (signal.SIGINT, signal.SIGTERM):
                signal.signal(end, signal.SIG_IGN)  # it is ending: a tenth of a second
            robot.stop()
        say(console, f"ended, arms powered off; {robot.commands} commands taken, {robot.dropped} lost")
        return 0


@dataclass
class Haptics:
    """Feel a scene on a CRTK master, real or simulated. Ends with Ctrl-C or SIGTERM, the force at zero.

    examples:
      palpate ros haptics scenes/wall.yaml
      palpate ros haptics scenes/wall.yaml --follower virtual --teleop none
      palpate ros haptics scenes/palpation.yaml --leader MTML --follower PSM2 --teleop MTML_PSM2 --force-cap 2

    With a teleoperation that runs (--teleop NAME), forces go by its hook following/mtm/body/servo_cf; with none, to the
    leader itself, and the follower is moved from here. A guardian process sends zeros where this one dies.
    """

    scene: Positional[Path]
    """Scene file (YAML)."""
    leader: str = "MTMR"
    """CRTK name of the master."""
    follower: str = "PSM1"
    """CRTK name of the patient-side arm; virtual: there is none, the tool is where the map puts it."""
    teleop: str = "MTMR_PSM1"
    """Teleoperation component that moves the follower; none: ours does."""
    console: str = "console"
    """Where pedals and operator presence are told."""
    force_cap: float | None = None
    """Largest force [N]; the smaller of the scene's and 1 N when left out."""
    rate: float | None = None
    """Of the cycle; the leader must publish as fast. The scene's when left out [Hz]."""
    tip_frame: bool = False
    """Wrenches go out in the tip's frame, and the arm is told so: for a master that knows no absolute one."""
    any_state: bool = False
    """For devices that tell no operating state: do not wait for ENABLED."""
    bare: bool = False
    """Forces alone: no frames, markers, diagnostics, parameters and services beside them."""
    duration: float | None = None
    """End after so long [s]."""
    network: bool = False
    """Talk to other machines; otherwise within this one alone."""
    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder for records, in place of the scene's."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the summary as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.ros_haptics import haptics

        return haptics(self)


@dataclass
class Topic:
    """What `ros2 topic` does, where the ros2 command is not installed: list, echo, hz, pub.

    examples:
      palpate ros topic list
      palpate ros topic echo /MTMR/measured_cp --count 1
      palpate ros topic hz /MTMR/measured_cp
      palpate ros topic pub /console/emulate_clutch sensor_msgs/msg/Joy "buttons: [1]"
      palpate ros topic pub /MTMR/body/servo_cf geometry_msgs/msg/WrenchStamped "wrench: {force: {z: 1}}"
    """

    what: Positional[Literal["list", "echo", "hz", "pub"]]
    """list: names and types; echo: each message as YAML; hz: how often and how evenly; pub: send one."""
    words: Positional[tuple[str, ...]] = ()
    """TOPIC; for pub: TOPIC TYPE YAML."""
    count: int | None = None
    """echo, hz: end after so many messages."""
    duration: float | None = None
    """echo, hz: end after so long [s]."""
    rate: float = 0.0
    """pub: again and again until Ctrl-C [Hz]; once when left out."""
    network: bool = False
    """Talk to other machines; otherwise within this one alone."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.ros_topic import topic

        return topic(self)


@dataclass
class Keystore:
    """Keys for DDS security (SROS 2), by openssl alone; says how to use them.

    examples:
      palpate ros keystore keys /palpate/sim /palpate/haptics
    """

    folder: Positional[Path]
    """Of the keystore; what is there stays."""
    enclaves: Positional[tuple[str, ...]]
    """Names, one for each process, e.g. /palpate/haptics."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.ros import keystore

        console = console_for(None)
        for place in keystore.make(self.folder, self.enclaves):
            say(console, f"made {place}")
        for name, value in keystore.environment(self.folder, self.enclaves[0] if self.enclaves else "/NAME").items():
            say(console, f"export {name}={value}")
        return 0


COMMANDS: dict[str, type] = {
    "setup": Setup,
    "sim": Sim,
    "haptics": Haptics,
    "topic": Topic,
    "keystore": Keystore,
}
