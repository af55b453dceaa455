"""`palpate ros haptics`."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rich.text import Text
from tyro.conf import Positional, arg

from palpate.base.errors import PalpateError
from palpate.cli.terminal.live_line import LiveLine
from palpate.cli.terminal.output import console_for, require_writable, say, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.session import Session, State


@dataclass
class Command:
    """Render a scene on a CRTK master, real or simulated. Ctrl-C or SIGTERM sets the force to zero and ends it.

    examples:
      palpate ros haptics scenes/wall.yaml
      palpate ros haptics scenes/wall.yaml --follower virtual --teleop none
      palpate ros haptics scenes/palpation.yaml --leader MTML --follower PSM2 --teleop MTML_PSM2 --force-cap 2

    With a running teleoperation component (--teleop NAME), forces go to its topic following/mtm/body/servo_cf. With
    --teleop none, forces go to the leader itself, and Palpate moves the follower. A guardian process sends zero
    wrenches if this process dies. A scene with pairs names the arms of each under devices, or a driver for a hand on a
    device; all pairs run in this process, each with its own node, guardian and record, and its topics in the namespace
    of its name.
    """

    scene: Positional[Path]
    """Scene file (YAML)."""
    leader: str = "MTMR"
    """CRTK name of the master."""
    follower: str = "PSM1"
    """CRTK name of the patient-side arm; virtual: no arm, the tool follows the mapped hand exactly."""
    teleop: str = "MTMR_PSM1"
    """Teleoperation component that moves the follower; none: Palpate moves it."""
    console: str = "console"
    """CRTK name of the console, which reports pedals and operator presence."""
    head_sensor: Annotated[str, arg(metavar="TOPIC")] = ""
    """Topic (sensor_msgs/Joy) of a head sensor that the console does not report as operator_present."""
    pedals: Annotated[str | None, arg(metavar="DEVICE")] = None
    """Also read foot switches, keyboards or gamepads, e.g. footswitch:/dev/input/event7."""
    force_cap: float | None = None
    """Largest force [N]; the scene's cap, but at most 1 N, when left out."""
    rate: float | None = None
    """Cycle rate, which the leader's publisher must reach; the scene's when left out [Hz]."""
    tip_frame: bool = False
    """Send wrenches in the tip's frame, and set this on the arm: for a master without absolute orientation."""
    any_state: bool = False
    """Do not wait for ENABLED: for devices that report no operating state."""
    trust: bool = False
    """Let a driver that the scene names run, although it is not installed: code beside the scene file."""
    bare: bool = False
    """Render forces only: no frames, markers, diagnostics, parameters or services."""
    pair: str = ""
    """Of a scene with pairs: the only pair to render, e.g. when each runs in a process of its own."""
    duration: float | None = None
    """End after this time [s]."""
    network: bool = False
    """Communicate with other machines; otherwise only within this one."""
    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder for records; the scene's record.folder when left out."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the summary as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Render the scene until the duration, Ctrl-C or SIGTERM ends it; returns the exit code."""
        from palpate.cli.commands._pedals import pedals
        from palpate.cli.terminal import outcome
        from palpate.report.summary import summary_table
        from palpate.ros.haptics import Devices, Limits
        from palpate.ros.pedal_topics import PedalTopics
        from palpate.ros.plant import CrtkPlant
        from palpate.scene import Scene
        from palpate.session import Session

        self._refuse()
        console = console_for(self.json)
        require_writable(self.json)
        scene = Scene.load(self.scene, self.trust)
        if scene.pairs:
            from palpate.cli.commands.ros._pairs import run_pairs

            return run_pairs(self, scene)
        if self.pair:
            mend = "leave --pair out, or give the scene a section pairs"
            raise PalpateError(f"--pair {self.pair}: the scene has no pairs", where=scene.file, mend=mend)
        plant = CrtkPlant(
            scene,
            Devices(self.leader, self.follower, self.teleop, self.console),
            Limits(self.force_cap, self.rate, self.tip_frame, not self.any_state),
            {"network": self.network},
        )
        session = Session(scene, out=self.out or Path(scene.record.folder), plant=plant)
        loop = plant.loop
        say(console, f"{self.leader} feels {scene.title or self.scene.stem}: wrenches to {loop.names.wrench}")
        say(console, f"force cap {loop.force_cap:g} N, {session.rate:g} Hz, guardian process {loop.guardian.pid}")
        with ExitStack() as stack:
            stack.enter_context(session)  # a node that never started leaves the network, too
            domain = loop.context.domain
            stack.enter_context(PedalTopics(session.console, domain, self.console, self.head_sensor))
            stack.enter_context(pedals(self.pedals, session.console, realtime=True))
            if not self.bare:
                from palpate.ros.around import Around

                stack.enter_context(Around(session))
            line = stack.enter_context(HapticLine(console, session))
            summary = session.run(self.duration, on_progress=line)
        line.rest()
        summary = outcome.with_report(summary, outcome.wants_report(scene, viewer=False))
        console.print(summary_table(summary))
        outcome.print_details(console, summary)
        write_json(self.json, summary)
        return int(session.failed)

    def _refuse(self) -> None:
        if self.force_cap is not None and not 0.0 <= self.force_cap <= 20.0:
            raise PalpateError(
                f"--force-cap {self.force_cap:g}: must be 0 to 20 N", mend="begin low, e.g. --force-cap 0.5"
            )
        if self.duration is not None and not 0.0 < self.duration < 1e7:
            raise PalpateError(
                f"--duration {self.duration:g}: must be above 0 s", mend="give seconds, e.g. --duration 60"
            )
        if self.rate is not None and not 50.0 <= self.rate <= 10000.0:
            raise PalpateError(
                f"--rate {self.rate:g}: must be 50 to 10000 Hz", mend="the rate at which the leader publishes"
            )


class HapticLine(LiveLine):
    """The live line: rate, latency, force, and the conditions that forbid a force; events are printed line by line.

    New conditions are events. A cause that repeats is counted, once a minute.
    """

    def __init__(self, console: Console, session: Session) -> None:
        from palpate.ros.plant import News

        super().__init__(console)
        self._session, self._news = session, News(session)

    def __call__(self, state: State) -> None:
        """Show the newest state."""
        self.rest()
        timing = self._session.timing
        if self._live is None:
            return
        from palpate.record import withheld
        from palpate.ros.causes import conditions

        words = [*conditions(int(state.tick["status"]))[:2], *withheld.in_words(state.tick)]
        line = Text.assemble(
            (f"{state.t:7.1f} s", "bold"),
            ("  leader ", "dim"),
            f"{timing['leader_rate']:6.0f} Hz",
            ("  answer ", "dim"),
            f"{timing['answer_us']['p50']:.0f} / {timing['answer_us']['p99']:.0f} us",
            ("  force ", "dim"),
            (f"{state.force:5.2f} N", "red" if state.contacts else ""),
            f"  {'; '.join(words) or self._session.nearest(state.tick) or 'free to push'}",
        )
        self._live.update(line)

    def rest(self) -> None:
        """Print the events since the last call."""
        for words in self._news.take():
            say(self._console, words, "*", "cyan")
