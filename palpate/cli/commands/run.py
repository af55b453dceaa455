"""`palpate run`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, UseAppendAction, arg

from palpate.base.errors import PalpateError
from palpate.cli.commands._leader import with_leaders
from palpate.cli.commands._pedals import pedals
from palpate.cli.commands._task import drawn as _with_task
from palpate.cli.commands._task import task_of, with_result
from palpate.cli.terminal import HOST, PORT

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.cli.terminal.device import DeviceLine
    from palpate.cli.terminal.progress import Progress
    from palpate.scene import Scene
    from palpate.session import Session
    from palpate.session.remote.link import RemoteLink
    from palpate.session.summary import Summary
    from palpate.session.tasks import TaskRun


@dataclass
class Command:
    """Run a scene: a simulated hand palpates it, and the run is recorded and summarised.

    examples:
      palpate run palpation
      palpate run nodule --headless --duration 5 --json run.json
      palpate run my.yaml --realtime --seed 7 --out /data/runs
      palpate run palpation --leader haply

    In a terminal the scene runs in real time in the 3-D viewer, which stays open until its stop button or Ctrl-C.
    Without a terminal, or with --headless, it runs as fast as possible and ends by itself. Ctrl-C stops a run at any
    moment: the record is closed, the summary is printed, the exit code is 130.
    """

    scene: Positional[Path]
    """Scene file (YAML), or the name of a shipped scene (palpate scenes lists them)."""
    trust: bool = False
    """Let the driver that the scene names run, although it is not installed: code beside the scene file."""
    leader: Annotated[UseAppendAction[tuple], arg(metavar="[PAIR=]DRIVER")] = ()  # type: ignore[type-arg] # tyro then needs no typeguard
    """Feel the scene on this device instead of its leader: a name of `palpate device list`, e.g. haply. In a scene with
    several pairs once for each hand, e.g. --leader right=haply:id=04C3 --leader left=haply:id=04C4."""
    headless: bool = False
    """Run without the viewer even in a terminal; in lockstep unless --realtime is given."""
    duration: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Simulated time [s]; the scene's when left out. A scene with a driver then runs until Ctrl-C."""
    realtime: bool = False
    """Run in real time, in a real-time thread."""
    fast: bool = False
    """Run in lockstep, as fast as possible: the same scene and seed give the same record, byte for byte."""
    seed: int | None = None
    """Seed of the random numbers [-]; the scene's when left out."""
    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder for records and reports; the scene's record.folder when left out."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the summary as JSON (docs/json.md); - for the standard output, all else then goes to stderr."""
    serve: bool = False
    """Show the run in the viewer even without a terminal."""
    openigtlink: Annotated[int | None, arg(metavar="PORT")] = None
    """Send frames and force to 3D Slicer during the run, on this port of 127.0.0.1 (docs/frames.md); e.g. 18944."""
    plan: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """Let this motion plan move the tool first (palpate plan --out); the hand takes over at its end."""
    record_places: Annotated[Path | None, arg(metavar="FILE.yaml")] = None
    """Store the follower's joints at each press of the pedal coag: start, way points and goal of a plan; of several
    pairs in FILE-PAIR.yaml for each."""
    speed: float = 1.0
    """Pace of the plan, 1: as planned [-]."""
    remote: Annotated[str | None, arg(metavar="HOST:PORT")] = None
    """Feel the scene as the follower there measures it (palpate serve follower); in real time (docs/network.md)."""
    key: Annotated[Path | None, arg(metavar="FILE")] = None
    """The key that is shared with that follower; default: that of `palpate keys`."""
    pedals: Annotated[str | None, arg(metavar="KIND:FILE")] = None
    """Foot switches, keyboards or gamepads as pedals, several in quotes, e.g. footswitch:/dev/input/event7."""
    port: int = PORT
    """Port of the viewer; the next free one when it is taken."""
    host: str = HOST
    """Address on which the viewer listens: 127.0.0.1 for this machine only; others ask for the printed token."""

    def __call__(self) -> int:
        """Run the scene, print the summary, serve the viewer if requested; returns the exit code."""
        from palpate.cli.terminal import outcome
        from palpate.cli.terminal.output import console_for, require_writable, write_json
        from palpate.cli.terminal.view import live, open_page, require_viewer
        from palpate.scene import Scene

        self._refuse_contradictions()
        self.task: TaskRun | None = None
        self.failed = False  # a device has ended its run
        console = console_for(self.json)
        viewer = self.serve or (not self.headless and sys.stdout.isatty() and sys.stdin.isatty())
        if viewer:
            require_viewer()
        require_writable(self.json)
        scene = _with_task(Scene.load(self.scene, self.trust), self.seed)
        scene = with_leaders(scene, self.leader)
        if self.plan is not None and not scene.pairs and scene.arms.leader.driver is not None:
            what = "--plan has no effect on a scene with a driver"
            raise PalpateError(what, mend="leave it out; palpate ros move moves real arms")
        self._require_remote(scene)
        if scene.pairs:
            from palpate.cli.commands._pairs import run_pairs

            return run_pairs(self, scene, viewer)
        if scene.arms.leader.driver is not None and (self.fast or self.seed is not None):
            what = "--fast" if self.fast else "--seed"
            raise PalpateError(f"{what} has no effect on a scene with a driver", mend="leave it out")
        report = partial(_report, console, outcome.wants_report(scene, viewer))
        if viewer:
            page = open_page(scene.title, self.port, console, self.host)
            run = partial(self._run, console=console, realtime=not self.fast)
            summary = live(partial(self._session, scene, console, page.say), run, report, page, console)
        else:
            summary = report(self._run(self._session(scene, console), console, self.realtime))
        write_json(self.json, with_result(summary, self.task, console))
        if scene.arms.leader.driver is not None and self.duration is None:  # such a run ends by Ctrl-C
            summary = replace(summary, interrupted=False)
        return outcome.exit_code(summary) or int(self.failed)

    def _session(self, scene: Scene, console: Console, say: Callable[[str], None] = lambda line: None) -> Session:
        from palpate.cli.terminal import output
        from palpate.devices.certificate.scene import warn_outside
        from palpate.scene import doubts
        from palpate.session import Session

        if any(s.topic is not None and s.replay is None for s in scene.sensors.values()):
            from palpate.ros import build

            say("preparing the messages of ROS 2")
            build.messages(say)
        say("reading surfaces, placing arms and planning the path")
        session = Session(scene, out=self.out or Path(scene.record.folder), seed=self.seed)
        self.task = task_of(session)
        if self.plan is not None:
            from palpate.planning import load

            say("checking the plan in the scene")
            session.execute(load(self.plan), self.speed)
        self._record_places(session)
        doubts.warn_of_coarse_meshes(session.scene, session.rig.surfaces)
        if session.plant.simulated:
            say("computing the stability certificate")
            warn_outside(session.rig)
        else:  # a device has its own certificate: palpate device bench
            stability = session.scene.stability
            words = f"{session.scene.arms.leader.driver} feels {scene.title}: at most {stability.force_cap:g} N"
            output.say(console, f"{words}, {session.rate:g} Hz; Ctrl-C ends it")
        return session

    def _record_places(self, session: Session) -> None:
        if self.record_places is not None:
            from palpate.session.places import PlaceRecorder

            PlaceRecorder(session, self.record_places)

    def _run(self, session: Session, console: Console, realtime: bool) -> Summary:
        from palpate.cli.commands._remote import joined
        from palpate.cli.terminal.output import say

        realtime = realtime or self.is_remote(session.scene) or not session.plant.simulated
        with (
            self._progress(session, console, realtime) as progress,
            self.sender(session),
            pedals(self.pedals, session.console, realtime),
            joined(session, self.remote, self.key) as link,
        ):
            summary = session.run(self.duration, realtime=realtime, on_progress=progress)
        self.failed = session.failed
        summary = _with_link(summary, link, console)
        if session.execution is not None:
            say(console, session.execution.words())
        return summary

    def _progress(self, session: Session, console: Console, realtime: bool) -> Progress | DeviceLine:
        from palpate.cli.terminal.device import DeviceLine
        from palpate.cli.terminal.progress import Progress

        if not session.plant.simulated:
            return DeviceLine(console, session.nearest)
        duration = session.scene.duration if self.duration is None else self.duration
        return Progress(
            console, duration, "real time" if realtime else "lockstep, as fast as possible", session.nearest
        )

    def is_remote(self, scene: Scene) -> bool:
        """True if the scene is felt across a network."""
        return self.remote is not None or (scene.remote is not None and scene.remote.together)

    def _require_remote(self, scene: Scene) -> None:
        """Refuse what cannot run across a network, before anything starts."""
        from palpate.cli.commands._remote import require

        if self.is_remote(scene):
            require(scene, self.remote, self.fast)
        elif self.key is not None:
            raise PalpateError("--key has no effect without --remote", mend="give --remote HOST:PORT, or leave it out")

    def sender(self, sessions: Session | Mapping[str, Session]) -> AbstractContextManager[object]:
        """What sends the frames of the session, or of the pairs by name, to 3D Slicer, if it is wanted."""
        if self.openigtlink is None:
            return nullcontext()
        from palpate.sensing.trackers.sending import FrameSender

        return FrameSender(sessions, self.openigtlink)

    def _refuse_contradictions(self) -> None:
        if self.realtime and self.fast:
            raise PalpateError("--realtime and --fast contradict each other", mend="give one of them, or none")
        if self.serve and self.headless:
            raise PalpateError("--serve and --headless contradict each other", mend="give one of them, or none")
        if self.duration is not None and not 0.0 < self.duration < 1e7:
            raise PalpateError(
                f"--duration {self.duration:g}: must be above 0 s", mend="give seconds, e.g. --duration 20"
            )
        if self.seed is not None and not 0 <= self.seed < 2**64:
            raise PalpateError(f"--seed {self.seed}: must be a whole number from 0", mend="give e.g. --seed 1")


def _with_link(summary: Summary, link: RemoteLink | None, console: Console) -> Summary:
    """The summary with what a link has measured, which is printed as well."""
    from palpate.cli.terminal.output import say

    if link is None:
        return summary
    say(console, link.words())
    return replace(summary, remote=link.figures())


def _report(console: Console, wanted: bool, summary: Summary) -> Summary:
    """Write the report of a run if it is wanted, and print its summary."""
    from palpate.cli.terminal import outcome
    from palpate.report.summary import summary_table

    summary = outcome.with_report(summary, wanted)
    console.print(summary_table(summary))
    outcome.print_details(console, summary)
    return summary
