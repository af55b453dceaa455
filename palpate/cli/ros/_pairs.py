"""`palpate ros haptics` of a scene with several pairs: one haptic node a pair, in one process."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from palpate.console.output import console_for, say, write_json
from palpate.errors import PalpateError

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.ros.haptics import HapticSession
    from palpate.scene import Scene

_PERIOD = 0.1  # between two checks of the nodes [s]


class Options(Protocol):
    """The options of `palpate ros haptics`."""

    console: str
    force_cap: float | None
    rate: float | None
    tip_frame: bool
    any_state: bool
    bare: bool
    duration: float | None
    pair: str
    network: bool
    out: Path | None
    json: Path | None


def run_pairs(command: Options, scene: Scene) -> int:
    """Render every pair of a scene on its arms until the duration, Ctrl-C or SIGTERM; returns the exit code.

    Raises:
        PalpateError: a pair has no names of its arms.
    """
    from palpate.console import outcome
    from palpate.report.summary import summary_table
    from palpate.scene.together import build_pairs
    from palpate.session import signals

    require_devices(scene)
    build_pairs(scene)  # refuses arms that stand in each other before anything moves
    console = console_for(command.json)
    with ExitStack() as stack:
        sessions: dict[str, HapticSession] = {}
        for name in wanted(scene, command.pair):
            sessions[name] = stack.enter_context(_session(command, scene, name))
            say(console, f"{name}: {sessions[name].devices.leader}, wrenches to {sessions[name].loop.names.wrench}")
        for name, session in sessions.items() if not command.bare else ():
            from palpate.ros.around import Around

            stack.enter_context(Around(session, pair=name, draws_objects=name == next(iter(sessions))))
        first = next(iter(sessions.values()))
        with signals.deferred(first.stopped):
            for session in sessions.values():
                session.start()
            _watch(sessions, command.duration, console)
        summaries = {name: session.close(first.stopped.is_set()) for name, session in sessions.items()}
    each = scene.each_pair()
    summaries = {name: outcome.with_report(summary, each[name]) for name, summary in summaries.items()}
    for name, summary in summaries.items():
        say(console, name, "pair", "bold")
        console.print(summary_table(summary))
        outcome.print_details(console, summary, scene.record.report)
    write_json(command.json, {"pairs": summaries})
    return 0


def wanted(scene: Scene, pair: str) -> list[str]:
    """The pairs to render: all, or the one that is named.

    Raises:
        SceneError: there is no such pair.
    """
    if pair:
        scene.pair(pair)
    return [pair] if pair else list(scene.pairs)


def require_devices(scene: Scene) -> None:
    """Refuse a scene in which a pair does not name its arms.

    Raises:
        PalpateError: the message names the pair and the line.
    """
    for name, pair in scene.pairs.items():
        if pair.devices is None:
            raise PalpateError(
                f"pair {name} does not name its arms on ROS 2",
                where=scene.where("pairs", name),
                mend="add devices: {leader: MTML, follower: PSM2, teleop: MTML_PSM2}",
            )


def _session(command: Options, scene: Scene, name: str) -> HapticSession:
    from palpate.ros.haptics import Devices, HapticSession, Limits

    devices = scene.pairs[name].devices
    assert devices is not None
    folder = command.out or Path(scene.record.folder)
    return HapticSession(
        scene.pair(name),
        Devices(devices.leader, devices.follower, devices.teleop, command.console, name),
        Limits(command.force_cap, command.rate, command.tip_frame, not command.any_state),
        out=folder / name,
        context={"network": command.network},
    )


def _watch(sessions: dict[str, HapticSession], duration: float | None, console: Console) -> None:
    """Print the events of all nodes until the end; a node that fails ends alone, and the others go on."""
    first = next(iter(sessions.values()))
    end = time.monotonic() + (float("inf") if duration is None else duration)
    printed = dict.fromkeys(sessions, 0)
    failed: set[str] = set()
    while time.monotonic() < end and not first.stopped.wait(_PERIOD) and len(failed) < len(sessions):
        for name, session in sessions.items():
            if name in failed:
                continue
            try:
                session.check_node()
            except PalpateError as error:
                failed.add(name)
                session.stop()
                say(console, f"{name}: {error}", "fault:", "red")
            for words in session.events[printed[name] :]:
                say(console, f"{name}: {words}", "*", "cyan")
            printed[name] = len(session.events)
