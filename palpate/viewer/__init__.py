"""The 3-D viewer in the browser: shows a session or a record, and lets the user move the hand.

    palpate.viewer.serve(session)             # until Ctrl-C
    palpate.viewer.serve(Record.open(path))   # with a time slider

The server binds to this machine (127.0.0.1) by default, and to another address behind a token. The page loads nothing
from elsewhere.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

from palpate.base import stop_signals
from palpate.record.reader import Record
from palpate.record.ticks import Ticks
from palpate.session import Session
from palpate.viewer.live import LiveViewer
from palpate.viewer.replay import ReplayViewer
from palpate.viewer.stage import Stage
from palpate.viewer.staging import stage_of, stage_of_record

__all__ = ["LiveViewer", "ReplayViewer", "serve", "stage_of", "stage_of_record"]


def serve(
    shown: Session | Record | tuple[Stage, Ticks],
    host: str = "127.0.0.1",
    port: int = 8080,
    on_ready: Callable[[str], None] = lambda url: None,
) -> None:
    """Shows a session while it runs in real time, or a record with a time slider, until Ctrl-C.

    Args:
        shown: a session (it continues from its present state, and is stopped but not closed at the end), a record, or
            ticks of another origin with the stage to draw them in.
        host: address to bind to; other than loopback, a browser needs the token in the address.
        port: 0 takes a free one.
        on_ready: called with the address once a browser can open it.

    Raises:
        PortError: the port cannot be used; the session was not started.
        RecordError, SceneError, MeshError: the scene of the record cannot be rebuilt.
        KeyboardInterrupt: Ctrl-C, after the viewer is closed.
    """
    if not isinstance(shown, Session):
        stage, run = (stage_of_record(shown), shown) if isinstance(shown, Record) else shown
        replayed = ReplayViewer(run, stage, host, port)
        try:
            on_ready(replayed.url)
            stop_signals.wait(threading.Event())
        finally:
            replayed.close()
        return
    live = LiveViewer(shown, stage_of(shown.rig), host, port)
    try:
        shown.start()
        on_ready(live.url)
        stop_signals.wait(threading.Event())
    finally:
        shown.stop()
        live.close()
