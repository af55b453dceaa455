"""`palpate ros haptics` of a scene with several pairs: one haptic node for each pair on ROS 2, in one process."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from palpate.cli.terminal.output import console_for, say, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.scene import Scene
    from palpate.session import PairsSession
    from palpate.session.pairs import States


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
    """Render the pairs of a scene on their arms and devices until the duration, Ctrl-C or SIGTERM.

    Returns:
        The exit code: 1 if a node or a device failed.

    Raises:
        PalpateError: a pair names neither arms nor a driver, or none is on ROS 2.
    """
    from palpate.cli.commands._pairs import report
    from palpate.cli.commands._pedals import pedals
    from palpate.cli.terminal.pairs import PairsProgress
    from palpate.ros.haptics import Limits
    from palpate.ros.pairs import plants_of
    from palpate.ros.pedal_topics import PedalTopics
    from palpate.session import PairsSession

    console, names = console_for(command.json), wanted(scene, command.pair)
    limits = Limits(command.force_cap, command.rate, command.tip_frame, not command.any_state)
    plants = plants_of(scene, limits, names, command.console, {"network": command.network})
    folder = command.out or Path(scene.record.folder)
    with ExitStack() as stack:
        session = stack.enter_context(PairsSession(scene, folder, plants=plants, only=names))
        for name, plant in plants.items():
            say(console, f"{name}: {plant.devices.leader}, wrenches to {plant.loop.names.wrench}")
        domain = next(iter(plants.values())).loop.context.domain
        stack.enter_context(
            PedalTopics(session.console, domain, command.console, command.head_sensor, space=command.pair)
        )
        stack.enter_context(pedals(command.pedals, session.console, realtime=True))
        for name in plants if not command.bare else ():
            from palpate.ros.around import Around

            stack.enter_context(Around(session.pairs[name], pair=name, draws_objects=name == next(iter(plants))))
        news = _News(console, session)
        progress = stack.enter_context(
            PairsProgress(console, None, "real time", {k: one.nearest for k, one in session.pairs.items()}, news.ended)
        )

        def show(states: States) -> None:
            progress(states)
            news.tell()

        summary = session.run(command.duration, on_progress=show)
        failed = any(news.ended().values())
    news.tell()
    write_json(command.json, report(console, scene, False, summary))
    return int(failed)


def wanted(scene: Scene, pair: str) -> list[str]:
    """The pairs to render: all, or the one that is named.

    Raises:
        SceneError: there is no such pair.
    """
    if pair:
        scene.pair(pair)
    return [pair] if pair else list(scene.pairs)


class _News:
    """Prints what happens to each pair."""

    def __init__(self, console: Console, session: PairsSession) -> None:
        from palpate.ros.plant import News

        self._console, self._session = console, session
        self._news = {name: News(one) for name, one in session.pairs.items()}

    def ended(self) -> dict[str, str | None]:
        """Why each pair ended by itself; None if it did not."""
        return {name: one.ended for name, one in self._session.pairs.items()}

    def tell(self) -> None:
        """Print the sentences since the last call."""
        for name, news in self._news.items():
            for words in news.take():
                say(self._console, f"{name}: {words}", "*", "cyan")
        self._console.file.flush()
