"""Buttons that run, step, record and stop a session; the session decides what they do."""

from __future__ import annotations

import threading
import time
from typing import Any, Protocol

import viser

from palpate.record.ticks import Ticks
from palpate.viewer.controls import set_value

STEP = 0.01
"""Smallest simulated time of a single step [s]."""


class Runner(Protocol):
    """A session that can be stepped and recorded from outside."""

    controls: Any
    """As `Source.controls`."""

    def latest(self) -> Ticks:
        """The newest tick."""
        ...

    def interrupt(self) -> None:
        """End a run before its duration is over."""
        ...

    def set_recording(self, on: bool) -> None:
        """End the present record; True begins a new one."""
        ...


class RunButtons:
    """Pause, single step, record, and stop with the report."""

    def __init__(self, gui: viser.GuiApi, runner: Runner | None, recording: bool) -> None:
        """`runner` None: only pausing is offered."""
        self._runner = runner
        self.stopped = threading.Event()
        """Set by the button that ends the session."""
        self.pause = gui.add_checkbox("pause", False, hint="Stops the simulated time")
        if runner is None:
            return
        self.step = gui.add_button("Step 10 ms", hint="Pauses, and runs for 10 ms of simulated time")
        hint = "On: all motion goes into a record, dragging included; off: ends the record"
        self.record = gui.add_checkbox("record", recording, hint=hint)
        self.stop = gui.add_button("Stop and report", hint="Ends the session, and opens its report")
        self.step.on_click(lambda _: self._step())
        self.record.on_update(lambda _: runner.set_recording(self.record.value))
        self.stop.on_click(lambda _: self._end())

    def _end(self) -> None:
        self.stopped.set()
        if self._runner is not None:
            self._runner.interrupt()

    def _step(self) -> None:
        set_value(self.pause, True)
        if self._runner is not None:
            _advance(self._runner, STEP)


def _advance(runner: Runner, seconds: float) -> None:
    """Let a paused session run for a simulated time [s], and a few ticks more; pause it again."""
    until = float(runner.latest()["t"]) + seconds - 1e-9
    deadline = time.monotonic() + 1.0
    _pause(runner, False)
    while float(runner.latest()["t"]) < until and time.monotonic() < deadline:
        time.sleep(5e-4)
    _pause(runner, True)


def _pause(runner: Runner, on: bool) -> None:
    controls = runner.controls
    controls.paused = on
    runner.controls = controls
