"""`palpate ros haptics`."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.text import Text

from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.cli.progress import LiveLine
from palpate.cli.run import tell, with_report
from palpate.errors import PalpateError
from palpate.scene import Scene
from palpate.session import State

if TYPE_CHECKING:
    from palpate.cli.ros import Haptics
    from palpate.ros.haptics import HapticSession


def haptics(o: Haptics) -> int:
    """Feel a scene until somebody ends it; returns the exit code."""
    from palpate.report.summary import summary_table
    from palpate.ros.haptics import Devices, HapticSession, Limits

    _refuse(o)
    console = console_for(o.json)
    require_writable(o.json)
    scene = Scene.load(o.scene)
    session = HapticSession(
        scene,
        Devices(o.leader, o.follower, o.teleop, o.console),
        Limits(o.force_cap, o.rate, o.tip_frame, not o.any_state),
        out=o.out or Path(scene.record.folder),
        context={"network": o.network},
    )
    loop = session.loop
    say(console, f"{o.leader} feels {scene.title or o.scene.stem}: wrenches to {loop.names.wrench}")
    say(console, f"force cap {loop.force_cap:g} N, {session.rate:g} Hz, guardian {loop.guardian.pid}")
    with ExitStack() as beside:
        if not o.bare:
            from palpate.ros.around import Around

            beside.enter_context(Around(session))
        line = beside.enter_context(Line(console, session))
        summary = session.run(o.duration, on_progress=line)
    line.rest()
    summary = with_report(summary, scene)
    console.print(summary_table(summary))
    tell(console, summary, scene.record.report)
    write_json(o.json, summary.to_json())
    return 0


def _refuse(o: Haptics) -> None:
    if o.force_cap is not None and not 0.0 <= o.force_cap <= 20.0:
        raise PalpateError(f"--force-cap {o.force_cap:g}: must be 0 to 20 N", mend="begin low, e.g. --force-cap 0.5")
    if o.duration is not None and not 0.0 < o.duration < 1e7:
        raise PalpateError(f"--duration {o.duration:g}: must be above 0 s", mend="give seconds, e.g. --duration 60")
    if o.rate is not None and not 50.0 <= o.rate <= 10000.0:
        raise PalpateError(f"--rate {o.rate:g}: must be 50 to 10000 Hz", mend="the rate at which the leader publishes")


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
