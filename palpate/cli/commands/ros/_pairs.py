"""`palpate ros haptics` of a scene with several pairs: one haptic node a pair, in one process."""

from __future__ import annotations

import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from palpate.base.errors import PalpateError
from palpate.cli.terminal.output import console_for, say, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.ros.pairs import HapticPairs
    from palpate.scene import Scene

_PERIOD = 0.1  # between two checks of the nodes [s]


class Options(Protocol):
    """The options of `palpate ros haptics`."""

    console: str
    head_sensor: str
    pedals: str | None
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
    """Render every pair of a scene on its arms until the duration, Ctrl-C or SIGTERM.

    Returns:
        The exit code: 1 if a node failed.

    Raises:
        PalpateError: a pair has no names of its arms.
    """
    from palpate.base import stop_signals
    from palpate.cli.commands._pedals import pedals
    from palpate.cli.terminal import outcome
    from palpate.report.summary import summary_table
    from palpate.ros.haptics import Limits
    from palpate.ros.pairs import HapticPairs
    from palpate.ros.pedal_topics import PedalTopics

    console, names = console_for(command.json), wanted(scene, command.pair)
    limits = Limits(command.force_cap, command.rate, command.tip_frame, not command.any_state)
    folder = command.out or Path(scene.record.folder)
    with ExitStack() as stack:
        pairs = HapticPairs(scene, limits, names, command.console, folder, {"network": command.network})
        stack.enter_context(pairs)
        for name, session in pairs.sessions.items():
            say(console, f"{name}: {session.devices.leader}, wrenches to {session.loop.names.wrench}")
        stack.enter_context(
            PedalTopics(pairs.console, pairs.domain, command.console, command.head_sensor, space=command.pair)
        )
        stack.enter_context(pedals(command.pedals, pairs.console, realtime=True))
        for name, session in pairs.sessions.items() if not command.bare else ():
            from palpate.ros.around import Around

            stack.enter_context(Around(session, pair=name, draws_objects=name == next(iter(scene.pairs))))
        with stop_signals.deferred(pairs.stopped):
            pairs.start()
            failed = _watch(pairs, command.duration, console)
        summaries = pairs.close(pairs.stopped.is_set())
    each = scene.each_pair()
    if not any(summary.interrupted for summary in summaries.values()):  # Ctrl-C ends at once; palpate report writes it
        summaries = {
            name: outcome.with_report(summary, outcome.wants_report(each[name], viewer=False))
            for name, summary in summaries.items()
        }
    for name, summary in summaries.items():
        say(console, name, "pair", "bold")
        console.print(summary_table(summary))
        outcome.print_details(console, summary)
    write_json(command.json, {"pairs": summaries})
    return 1 if failed else 0


def wanted(scene: Scene, pair: str) -> list[str]:
    """The pairs to render: all, or the one that is named.

    Raises:
        SceneError: there is no such pair.
    """
    if pair:
        scene.pair(pair)
    return [pair] if pair else list(scene.pairs)


def _watch(pairs: HapticPairs, duration: float | None, console: Console) -> set[str]:
    """Print the events of all nodes until the end; a node that fails ends alone, and the others go on.

    Returns:
        Names of the pairs whose node failed.
    """
    end = time.monotonic() + (float("inf") if duration is None else duration)
    printed, failed = dict.fromkeys(pairs.sessions, 0), set[str]()
    while time.monotonic() < end and not pairs.stopped.wait(_PERIOD) and len(failed) < len(pairs.sessions):
        for name, session in pairs.sessions.items():
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
            console.file.flush()
    return failed
