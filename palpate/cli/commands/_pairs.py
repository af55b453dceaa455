"""`palpate run` of a scene with several pairs."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from palpate.base.errors import PalpateError
from palpate.cli.commands._pedals import pedals
from palpate.cli.commands._task import task_of, with_result
from palpate.cli.terminal.output import console_for, say, write_json

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from contextlib import AbstractContextManager

    from rich.console import Console

    from palpate.scene import Scene
    from palpate.session import PairsSession
    from palpate.session.pairs_summary import PairsSummary


class Options(Protocol):
    """The options of `palpate run`."""

    duration: float | None
    realtime: bool
    fast: bool
    seed: int | None
    out: Path | None
    json: Path | None
    pedals: str | None
    port: int
    host: str
    remote: str | None
    key: Path | None
    plan: Path | None
    record_places: Path | None
    speed: float
    task: Any
    failed: bool

    def is_remote(self, scene: Scene) -> bool:
        """True if the scene is felt across a network."""
        ...

    def sender(self, sessions: Mapping[str, Any]) -> AbstractContextManager[object]:
        """What sends the frames of the sessions to 3D Slicer, if it is wanted."""
        ...


def run_pairs(command: Options, scene: Scene, viewer: bool) -> int:
    """Run all pairs of a scene, print their summaries and write the JSON; returns the exit code."""
    console = console_for(command.json)
    driven = [name for name, one in scene.each_pair().items() if one.arms.leader.driver is not None]
    if driven and command.fast:
        what = f"--fast has no effect on a scene with a driver: pair {driven[0]} is felt on a device"
        raise PalpateError(what, mend="leave it out")
    from palpate.cli.terminal import outcome

    if viewer:
        from palpate.cli.terminal.view import live_pairs, open_page

        page = open_page(scene.title, command.port, console, command.host)
        begin = partial(_session, command, scene, page.say)
        run = partial(_run, command, console, realtime=not command.fast)
        summary = live_pairs(begin, run, partial(report, console, scene, viewer), page, console)
    else:
        session = _session(command, scene, lambda line: None)
        realtime = command.realtime or bool(driven) or command.is_remote(scene)
        summary = report(console, scene, viewer, _run(command, console, session, realtime))
    write_json(command.json, with_result(summary, command.task, console))
    return outcome.exit_code(*summary.pairs.values()) or int(command.failed)


def _session(command: Options, scene: Scene, say_progress: Callable[[str], None]) -> PairsSession:
    from palpate.devices.certificate.scene import warn_outside
    from palpate.scene import doubts
    from palpate.session import PairsSession

    say_progress("reading surfaces, placing arms and planning the paths")
    session = PairsSession(scene, out=command.out or Path(scene.record.folder), seed=command.seed)
    command.task = task_of(session)
    if command.plan is not None:
        from palpate.planning import load

        say_progress("checking the plan in the scene")
        session.execute(load(command.plan), command.speed)
    if command.record_places is not None:
        from palpate.session.places import PlaceRecorder

        for name, pair in session.pairs.items():
            file = command.record_places.with_stem(f"{command.record_places.stem}-{name}")
            PlaceRecorder(pair, file, console=session.console)
    say_progress("computing the stability certificates")
    for k, rig in enumerate(session.rigs.values()):
        if k == 0:  # the pairs share the objects
            doubts.warn_of_coarse_meshes(rig.scene, rig.surfaces)
        if rig.scene.arms.leader.driver is None:  # a device has its own certificate: palpate device bench
            warn_outside(rig)
    return session


def _run(command: Options, console: Console, session: PairsSession, realtime: bool) -> PairsSummary:
    from palpate.cli.commands._remote import joined
    from palpate.cli.terminal.pairs import PairsProgress

    usual = None if session.driven else session.scene.duration  # a scene with a device runs until Ctrl-C
    duration = usual if command.duration is None else command.duration
    mode = "real time" if realtime else "lockstep, as fast as possible"
    near = {name: pair.nearest for name, pair in session.pairs.items()}

    def ended() -> dict[str, str | None]:
        return {name: pair.ended for name, pair in session.pairs.items()}

    with (
        PairsProgress(console, duration, mode, near, ended) as progress,
        pedals(command.pedals, session.console, realtime),
        command.sender(session.pairs),
        joined(session, command.remote, command.key) as link,
    ):
        summary = session.run(duration, realtime=realtime, on_progress=progress)
    if link is not None:
        each = {name: replace(one, remote=link.figures(name)) for name, one in summary.pairs.items()}
        summary = replace(summary, pairs=each)
        for name in each:
            say(console, link.words(name))
    for name, pair in session.pairs.items():
        if pair.execution is not None:
            say(console, f"{name}: {pair.execution.words()}")
    command.failed = any(ended().values())
    return summary


def _with_page(summary: PairsSummary) -> PairsSummary:
    """Write the page of all pairs; a failure is added to the faults, or printed if an extra is missing."""
    from palpate.base.errors import MissingExtraError
    from palpate.report.pairs import write_pairs_report

    if summary.record is None:
        return summary
    try:
        return replace(summary, report=str(write_pairs_report(Path(summary.record), each=False)))
    except MissingExtraError:
        return summary  # said once for each pair
    except (PalpateError, OSError) as error:
        return replace(summary, faults=(*summary.faults, f"no report: {error}"))


def report(console: Console, scene: Scene, viewer: bool, summary: PairsSummary) -> PairsSummary:
    """Write the reports of all pairs that are wanted, and print their summaries."""
    from palpate.cli.terminal import outcome
    from palpate.cli.terminal.pairs import pairs_table

    each = scene.each_pair()
    pairs = {
        name: outcome.with_report(one, outcome.wants_report(each[name], viewer)) for name, one in summary.pairs.items()
    }
    faults = tuple(f"{name}: {fault}" for name, one in pairs.items() for fault in one.faults)
    interrupted = summary.interrupted or any(one.interrupted for one in pairs.values())
    summary = replace(summary, pairs=pairs, faults=faults, interrupted=interrupted)
    summary = _with_page(summary) if outcome.wants_report(scene, viewer) else summary
    console.print(pairs_table(summary))
    if summary.interrupted:
        say(console, "stopped by Ctrl-C; the records are complete up to this moment")
    for name, one in pairs.items():
        if one.scheduler:
            say(console, f"scheduling of {name}: {one.scheduler}")
    if summary.instruments.handles_close_s > 0.0:
        least = f"closer than {1e3 * scene.instruments.handle_distance:g} mm"
        words = f"the handles of two leaders were {least} for {summary.instruments.handles_close_s:.2f} s"
        say(console, words, "warning:", "yellow")
    for fault in summary.faults:
        say(console, fault, "fault:", "red")
    if summary.record is not None:
        say(console, f"records: {summary.record}")
        say(console, f"report: {summary.report or f'palpate report {summary.record}'}")
    return summary
