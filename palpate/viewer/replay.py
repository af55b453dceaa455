"""The viewer of a record: the same view and gauges, with a time slider instead of the console."""

from __future__ import annotations

import threading
import time
from functools import partial

import numpy as np

from palpate.record.reader import Record
from palpate.record.ticks import Ticks
from palpate.viewer import views
from palpate.viewer.controls import set_value, time_slider
from palpate.viewer.drawing import Drawing
from palpate.viewer.gauges import HISTORY, POINTS, WINDOW, Gauges
from palpate.viewer.labels import LabelPlacer
from palpate.viewer.picture import Picture
from palpate.viewer.played import Played
from palpate.viewer.recorded import Snapshots
from palpate.viewer.server import close_server, open_server, url
from palpate.viewer.stage import Stage
from palpate.viewer.surgeon import SurgeonView

FRAME_RATE = 30.0
"""Update rate of the view [Hz]."""
SPEEDS = {"x 0.1": 0.1, "x 0.25": 0.25, "x 1": 1.0, "x 2": 2.0}


class ReplayViewer:
    """Plays the ticks of a run in a loop, or shows the instant that the user chooses."""

    def __init__(self, run: Record | Ticks, stage: Stage, host: str = "127.0.0.1", port: int = 8080) -> None:
        """Opens the server and starts playing. run: a record, or ticks (n,), n >= 1. Raises PortError when the port
        cannot be used."""
        self._played = Played(run)
        self._server = open_server(host, port, stage.title)
        views.Framing(self._server, partial(views.overview, stage))
        self.url = url(self._server)
        self.picture = Picture(self._server)
        self._drawing = Drawing(self.picture.scene, stage)
        self._gauges = Gauges(self._server, stage, self._drawing)
        self._shown, self._end = -1, self._played.end()
        first, last = self._played.span
        gui = self._server.gui
        gui.set_panel_label(f"{stage.title}: replay")
        with gui.add_folder("Replay"):
            self.play = gui.add_checkbox("play", True)
            self.time = time_slider(gui, first, last)
            self.speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="x 1")
        self._snapshots = Snapshots(gui, self.picture.scene, stage, self._drawing)
        self.surgeon = None
        if stage.ecm is not None:
            with gui.add_folder("Endoscope"):
                self.surgeon = SurgeonView(self._server, stage.ecm, self._snapshots.joints, self._present)
        self.inset = views.add_buttons(self._server, stage, self._drawing)
        self._labels = LabelPlacer(self._server, self._drawing.labels)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(280)
        self.time.on_update(self._dragged)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-replay", daemon=True)
        self._thread.start()

    def show_at(self, t: float) -> None:
        """Stops playing and shows the instant t [s]."""
        set_value(self.play, False)
        set_value(self.time, float(np.clip(t, *self._played.span)))

    def close(self) -> None:
        """Stops playing and closes the port."""
        self._stop.set()
        self.inset.close()
        if self.surgeon is not None:
            self.surgeon.close()
        self._thread.join(timeout=2.0)
        close_server(self._server)

    def _dragged(self, event: object) -> None:
        """Stops playing when a user moves the slider; the player's own updates carry no client."""
        if getattr(event, "client", None) is not None:
            set_value(self.play, False)

    def _run(self) -> None:
        before = time.perf_counter()
        while not self._stop.wait(1.0 / FRAME_RATE):
            now = time.perf_counter()
            if self.play.value:
                self._advance((now - before) * SPEEDS[self.speed.value])
            before = now
            self._show(self._played.number(self.time.value))

    def _advance(self, dt: float) -> None:
        first, last = self._played.span
        t = self.time.value + dt
        set_value(self.time, t if t <= last else first)

    def _present(self) -> list[Ticks]:
        return [self._played.tick(max(self._shown, 0))]

    def _show(self, k: int) -> None:
        t = self._played.time(k)
        self.picture.at(t)
        if k == self._shown and (self._snapshots.soft is None or self._snapshots.soft.is_drawn):
            return
        self._shown = k
        tick, history = self._played.tick(k), self._played.window(HISTORY, k, WINDOW, POINTS)
        with self._server.atomic():
            self._drawing.set_light(self.picture.light)
            self._drawing.show(tick)
            self._snapshots.show(t)
            self._gauges.set_history(history)
            self._gauges.show(tick, over=k >= self._end)
            self._gauges.plot()
            self._labels.show(None, 0.0)
