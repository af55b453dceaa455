"""The viewer of the records of several pairs: all arms on one time axis, with a time slider."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from functools import partial
from typing import Any, cast

import numpy as np
import viser

from palpate.record.reader import Record
from palpate.record.ticks import Ticks
from palpate.viewer import views
from palpate.viewer.controls import set_value, time_slider
from palpate.viewer.drawing import Drawing
from palpate.viewer.pair_gauges import PairGauges
from palpate.viewer.pairs import COLORS, Within
from palpate.viewer.picture import Picture
from palpate.viewer.played import Played
from palpate.viewer.recorded import Snapshots
from palpate.viewer.replay import FRAME_RATE, SPEEDS
from palpate.viewer.server import close_server, open_server, url
from palpate.viewer.staging import stage_of_record
from palpate.viewer.surgeon import SurgeonView

_HANDLES = 0.08  # distance of two handles below which a warning appears [m]


class PairsReplayViewer:
    """Plays the records of a run of several pairs in a loop, or shows the instant that the user chooses.

    Args:
        records: record of each pair, by name.
        title: title of the page.
        host, port: as for `ReplayViewer`.

    Raises:
        PortError: the port cannot be used. RecordError, SceneError, MeshError: a scene cannot be rebuilt.
    """

    def __init__(self, records: Mapping[str, Record], title: str, host: str = "127.0.0.1", port: int = 8080) -> None:
        self._played = {name: Played(record) for name, record in records.items()}
        self._ends = {name: run.time(run.end()) for name, run in self._played.items() if run.end() < len(run)}
        stages = {name: stage_of_record(record) for name, record in records.items()}
        colors = dict(zip(stages, COLORS, strict=False))
        self._server = open_server(host, port, title)
        self.url = url(self._server)
        seen = np.concatenate([s.seen if len(s.seen) else s.focus[None] for s in stages.values()])
        views.Framing(self._server, partial(views.overview_of, seen))
        first = next(iter(stages))
        self.picture = Picture(self._server)
        self.drawings = {
            name: Drawing(
                cast("viser.SceneApi", Within(self.picture.scene, f"/{name}")), stage, name == first, colors[name]
            )
            for name, stage in stages.items()
        }
        self._gauges = PairGauges(self._server, stages, {}, colors, _HANDLES, None)
        begin = min(run.span[0] for run in self._played.values())
        self._last = max(run.span[1] for run in self._played.values())
        gui = self._server.gui
        gui.set_panel_label(f"{title}: replay")
        with gui.add_folder("Replay"):
            self.play = gui.add_checkbox("play", True)
            self.time = time_slider(gui, begin, self._last)
            self.speed = gui.add_dropdown("speed", tuple(SPEEDS), initial_value="x 1")
        self._snapshots = Snapshots(gui, self.picture.scene, stages[first], self.drawings[first])
        self._now = begin
        self.surgeon = None
        placed = stages[first].ecm
        if placed is not None:
            with gui.add_folder("Endoscope"):
                self.surgeon = SurgeonView(
                    self._server, placed, self._snapshots.joints, lambda: list(self._found(self._now).values())
                )
        gui.main_panel.dock_right()
        gui.main_panel.set_width(240)
        self._begin = begin
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-replay", daemon=True)
        self._thread.start()

    def show_at(self, t: float) -> None:
        """Stops playing and shows the instant t [s]."""
        set_value(self.play, False)
        set_value(self.time, float(np.clip(t, self._begin, self._last)))

    def close(self) -> None:
        """Stops playing and closes the port."""
        self._stop.set()
        if self.surgeon is not None:
            self.surgeon.close()
        self._thread.join(timeout=2.0)
        close_server(self._server)

    def _run(self) -> None:
        before = time.perf_counter()
        while not self._stop.wait(1.0 / FRAME_RATE):
            now = time.perf_counter()
            if self.play.value:
                t = self.time.value + (now - before) * SPEEDS[self.speed.value]
                set_value(self.time, t if t <= self._last else self._begin)
            before = now
            self.show(self.time.value)

    def _found(self, t: float) -> dict[str, Ticks]:
        """The tick of each pair at t [s]."""
        return {name: run.tick(run.number(t)) for name, run in self._played.items()}

    def show(self, t: float) -> None:
        """Draws all pairs at t [s]."""
        found, self._now = self._found(t), t
        with self._server.atomic():
            self.picture.at(t)
            for drawing in self.drawings.values():
                drawing.set_light(self.picture.light)
            presses: list[Any] = []
            for name in reversed(found):
                presses.append(self.drawings[name].show(found[name], presses))
            self._snapshots.show(t)
            self._gauges.add(found)
            over = [name for name, end in self._ends.items() if t >= end]
            self._gauges.show(found, False, over)
            self._gauges.plot()
