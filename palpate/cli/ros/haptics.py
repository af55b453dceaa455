"""`palpate ros haptics`."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from rich.text import Text
from tyro.conf import Positional, arg

from palpate.console.live_line import LiveLine
from palpate.console.output import console_for, require_writable, say, write_json
from palpate.errors import PalpateError

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.ros.haptics import HapticSession
    from palpate.session import State


@dataclass
class Command:
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
        """Feel a scene until somebody ends it; returns the exit code."""
        from palpate.console import outcome
        from palpate.report.summary import summary_table
        from palpate.ros.haptics import Devices, HapticSession, Limits
        from palpate.scene import Scene

        self._refuse()
        console = console_for(self.json)
        require_writable(self.json)
        scene = Scene.load(self.scene)
        session = HapticSession(
            scene,
            Devices(self.leader, self.follower, self.teleop, self.console),
            Limits(self.force_cap, self.rate, self.tip_frame, not self.any_state),
            out=self.out or Path(scene.record.folder),
            context={"network": self.network},
        )
        loop = session.loop
        say(console, f"{self.leader} feels {scene.title or self.scene.stem}: wrenches to {loop.names.wrench}")
        say(console, f"force cap {loop.force_cap:g} N, {session.rate:g} Hz, guardian {loop.guardian.pid}")
        with ExitStack() as beside:
            if not self.bare:
                from palpate.ros.around import Around

                beside.enter_context(Around(session))
            line = beside.enter_context(Line(console, session))
            summary = session.run(self.duration, on_progress=line)
        line.rest()
        summary = outcome.with_report(summary, scene)
        console.print(summary_table(summary))
        outcome.tell(console, summary, scene.record.report)
        write_json(self.json, summary.to_json())
        return 0

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


class Line(LiveLine):
    """The live line: rates, lateness, force, and what forbids it, in words. Below it, what happens, line by line.

    Without a terminal, a line for each change of what forbids the force.
    """

    def __init__(self, console: Console, session: HapticSession) -> None:
        super().__init__(console)
        self._session = session
        self._told, self._last = 0, ["?"]

    def __call__(self, state: State) -> None:
        """Show the newest state."""
        self.rest()
        timing = self._session.timing
        words = self._session.words(int(state.tick["status"]))
        line = Text.assemble(
            (f"{state.t:7.1f} s", "bold"),
            ("  leader ", "dim"),
            f"{timing['leader_rate']:6.0f} Hz",
            ("  answer ", "dim"),
            f"{timing['answer_us']['p50']:.0f} / {timing['answer_us']['p99']:.0f} us",
            ("  force ", "dim"),
            (f"{state.force:5.2f} N", "red" if state.contacts else ""),
            ("  ", "") if words else ("  free to push", "green"),
            ("; ".join(words[:2]), "yellow"),
        )
        if self._live is not None:
            self._live.update(line)
        elif words != self._last:
            self._console.print(line, soft_wrap=True)
        self._last = words

    def rest(self) -> None:
        """What happened since the last look."""
        for words in self._session.told[self._told :]:
            say(self._console, words, "*", "cyan")
        self._told = len(self._session.told)
