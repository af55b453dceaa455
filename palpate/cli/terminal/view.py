"""Serves the viewer from the command line, on the first free port, until Ctrl-C."""

from __future__ import annotations

import errno
import importlib.util
import socket
import webbrowser
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from palpate.base import stop_signals
from palpate.base.errors import MissingExtraError, PortError
from palpate.cli.terminal import HOST
from palpate.cli.terminal.output import say

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.record.reader import Record
    from palpate.record.ticks import Ticks
    from palpate.session import PairsSession, Session
    from palpate.session.pairs_summary import PairsSummary
    from palpate.session.summary import Summary
    from palpate.viewer import LiveViewer
    from palpate.viewer.opening import Opening
    from palpate.viewer.pairs import PairsViewer
    from palpate.viewer.run_buttons import RunButtons
    from palpate.viewer.stage import Stage

_TRIES = 20
_S = TypeVar("_S", "Session", "PairsSession")
_T = TypeVar("_T", "Summary", "PairsSummary")


def require_viewer() -> None:
    """Check before the run that the viewer is installed.

    Raises:
        MissingExtraError: the viewer is not installed.
    """
    if importlib.util.find_spec("viser") is None:
        raise MissingExtraError("the 3-D viewer", "viewer")


def free_port(wanted: int, host: str = HOST) -> int:
    """The wanted port of an address of this machine, or the next free one above it.

    Raises:
        PortError: the address is not one of this machine, the number is not a port, or this port and the next ones are
            all taken.
    """
    if not 0 < wanted < 65536:
        raise PortError(f"port {wanted} does not exist", mend="choose one from 1024 to 65535, e.g. --port 8080")
    last = min(wanted + _TRIES, 65536) - 1
    for port in range(wanted, last + 1):
        with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET) as s:
            s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                s.bind((host, port))
            except OSError as error:
                if isinstance(error, socket.gaierror) or error.errno == errno.EADDRNOTAVAIL:
                    raise PortError(
                        f"{host} is not an address of this machine",
                        why=error.strerror or str(error),
                        mend="name one of its addresses, or 0.0.0.0 for all: --host 0.0.0.0",
                    ) from None
                continue
            return port
    raise PortError(
        f"ports {wanted} to {last} are all taken or not allowed",
        where=host,
        mend="stop another viewer, or choose a port with --port",
    )


def open_page(title: str, port: int, console: Console, host: str = HOST) -> Opening:
    """Open the viewer's page on the first free port, and print its address, with a token unless `host` is loopback.

    Raises:
        PortError: no port is free.
    """
    from palpate.viewer.opening import Opening

    page = Opening(title, host, free_port(port, host))
    say(console, f"viewer: {page.url}   (Ctrl-C ends it)")
    return page


def live(
    begin: Callable[[], Session],
    run: Callable[[Session], Summary],
    report: Callable[[Summary], Summary],
    page: Opening,
    console: Console,
) -> Summary:
    """Load a session while the page says so, run it in the viewer, and go on until the stop button or Ctrl-C.

    Args:
        begin: loads the session.
        run: runs the session for its duration.
        report: writes the report of a closed record and prints the summary.
        page: the open page.
        console: where the end of the viewer is printed.

    Returns:
        The summary of `run`. Motion after `run` goes into a record of its own, unless its box is off.
    """
    from palpate.viewer import LiveViewer, stage_of

    def show(session: Session) -> tuple[LiveViewer, RunButtons]:
        shown = LiveViewer(session, stage_of(session.rig), server=page.server, runner=session)
        return shown, shown.control_panel.run

    def close(session: Session) -> Summary:
        return session.close()

    return _run_shown(begin, show, run, close, report, page, console)


def live_pairs(
    begin: Callable[[], PairsSession],
    run: Callable[[PairsSession], PairsSummary],
    report: Callable[[PairsSummary], PairsSummary],
    page: Opening,
    console: Console,
) -> PairsSummary:
    """As `live`, for all pairs of a scene."""
    from palpate.session.rates import LiveRates
    from palpate.viewer import stage_of
    from palpate.viewer.pairs import PairsViewer

    def show(session: PairsSession) -> tuple[PairsViewer, RunButtons]:
        stages = {name: stage_of(rig, name) for name, rig in session.rigs.items()}
        near = session.scene.instruments.handle_distance
        shown = PairsViewer(
            session.pairs, stages, session.scene.title, session, session, LiveRates(session.pairs).rows, near,
            server=page.server,
        )  # fmt: skip
        return shown, shown.run

    def close(session: PairsSession) -> PairsSummary:
        return session.close()

    return _run_shown(begin, show, run, close, report, page, console)


def _run_shown(
    begin: Callable[[], _S],
    show: Callable[[_S], tuple[LiveViewer | PairsViewer, RunButtons]],
    run: Callable[[_S], _T],
    close: Callable[[_S], _T],
    report: Callable[[_T], _T],
    page: Opening,
    console: Console,
) -> _T:
    """What `live` does, with the viewer and its buttons that `show` makes."""
    try:
        session = begin()
        page.say("drawing the scene")
        shown, buttons = show(session)
    except BaseException:
        page.close()
        raise
    page.done()
    try:
        summary = report(run(session))
        if summary.interrupted and not shown.stopped.is_set():
            return summary
        if not shown.stopped.is_set():
            session.set_recording(buttons.record.value)
            session.limit_record(1e9 * session.scene.record.limit_GB)
            if session.recording:
                most = f"{session.scene.record.limit_GB:g} GB at most (record.limit_GB)"
                say(console, f"all motion goes into a record of its own, of {most}; the box record ends it")
            session.start()
            _wait(session, shown, buttons, console)
            if session.recording:
                summary = replace(report(close(session)), interrupted=False)
        if shown.stopped.is_set() and summary.report is not None:
            webbrowser.open(Path(summary.report).resolve().as_uri())
        return replace(summary, interrupted=False)
    finally:
        session.stop()
        shown.close()


def _wait(
    session: Session | PairsSession,
    shown: LiveViewer | PairsViewer,
    buttons: RunButtons,
    console: Console,
) -> None:
    """Wait until the viewer is stopped; a record that ends at its limit is told, and its box unticked."""

    from palpate.viewer.controls import set_value

    def look() -> None:
        if buttons.record.value and not session.recording:
            set_value(buttons.record, False)
            size = f"{session.scene.record.limit_GB:g} GB"
            say(console, f"the record has {size} and ends; the box record begins another one")

    try:
        stop_signals.wait(shown.stopped, look)
    except KeyboardInterrupt:
        say(console, "viewer closed")


def serve(shown: Session | Record | tuple[Stage, Ticks], port: int, console: Console, host: str = HOST) -> None:
    """Serve a session (live), a record, or a stage with its ticks until Ctrl-C."""
    from palpate import viewer

    free = free_port(port, host)
    if free != port:
        say(console, f"port {port} is taken; using {free}")
    try:
        viewer.serve(
            shown, host=host, port=free, on_ready=lambda url: say(console, f"viewer: {url}   (Ctrl-C ends it)")
        )
    except KeyboardInterrupt:
        say(console, "viewer closed")
