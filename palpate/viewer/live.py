"""The live viewer: shows a running session at 30 Hz and sends it the user's changes."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from functools import partial

import numpy as np
import viser

from palpate.session import Session
from palpate.session.rates import LiveRates
from palpate.viewer import views
from palpate.viewer.bodies import BodiesDrawing, TaskWords
from palpate.viewer.clouds import CloudDrawing
from palpate.viewer.control_panel import ControlPanel
from palpate.viewer.drawing import Drawing
from palpate.viewer.fixtures import FixturePanel
from palpate.viewer.gauges import Gauges
from palpate.viewer.labels import LabelPlacer
from palpate.viewer.picture import Picture
from palpate.viewer.rates_panel import RatesPanel
from palpate.viewer.run_buttons import Runner
from palpate.viewer.server import NARROW, close_server, open_server, url
from palpate.viewer.soft_objects import SoftObjects
from palpate.viewer.source import Source
from palpate.viewer.stage import Stage
from palpate.viewer.surgeon import SurgeonView
from palpate.viewer.video import VideoPanel

FRAME_RATE = 30.0
"""Update rate of poses and arrows [Hz]."""
FRAMES_PER_READOUT, FRAMES_PER_PLOT = 3, 6
"""Frames between two updates of the read-outs (10 Hz) and of the plots (5 Hz)."""
FRAMES_PER_IDLE = 6
"""Of a scene that stands still, each sixth frame is drawn: what the user moves or chooses then appears in 0.2 s."""
LIGHT_SLOWER = 2
"""How many times more frames lie between them in a light picture."""


class LiveViewer:
    """A viewer of a running session; it reads the newest tick and never waits for the loop."""

    def __init__(
        self,
        source: Source,
        stage: Stage,
        host: str = "127.0.0.1",
        port: int = 8080,
        server: viser.ViserServer | None = None,
        runner: Runner | None = None,
    ) -> None:
        """Opens the server, unless one is open already, and starts drawing.

        Args:
            source: the running session.
            stage: what is drawn.
            host: address to bind to, if no server is given.
            port: port, if no server is given; 0 takes a free one.
            server: an open server (`palpate.viewer.opening`).
            runner: the session, if it can be stepped and recorded with buttons.

        Raises:
            PortError: the port cannot be used.
        """
        if isinstance(source, Session):  # it also knows the clouds of its sensors
            stage = replace(stage, near=source.nearest)
        self._source, self._stage = source, stage
        self._server = open_server(host, port, stage.title) if server is None else server
        views.Framing(self._server, partial(views.overview, stage))
        self.url = url(self._server)
        self.picture = Picture(self._server)
        self._drawing = Drawing(self.picture.scene, stage)
        sensing = getattr(source, "sensing", None)
        self._clouds = None if sensing is None else CloudDrawing(self._server.scene, sensing)
        self._gauges = Gauges(self._server, stage, self._drawing)
        self.control_panel = ControlPanel(self._server, stage, source, runner)
        self._wide = True  # the panels
        steered = source.steered if stage.fixtures else None
        self.guidance = (
            None if steered is None else FixturePanel(self._server, stage.fixtures, self._drawing.fixtures, steered)
        )
        self._video = VideoPanel(self._server.gui)
        self._rates = None
        if isinstance(source, Session):
            with self._gauges.panel.add_tab("Rates", viser.Icon.CLOCK):
                self._rates = RatesPanel(self._server.gui, LiveRates({"": source}).rows)
        world, words = getattr(source, "world", None), getattr(source, "task_words", None)
        self._bodies = None if world is None else BodiesDrawing(self.picture.scene, stage.solids, world.drawn)
        self._task = None if words is None else TaskWords(self._server.gui, words)
        self.soft = None
        if isinstance(source, Session) and any(obj.soft for obj in stage.objects):
            self.soft = SoftObjects(self._server.gui, stage, self._drawing, source)
        self.inset = views.add_buttons(self._server, stage, self._drawing)
        camera = self._camera = getattr(source, "camera", None)
        self.surgeon = None
        if camera is not None and stage.ecm is not None:
            self.surgeon = SurgeonView(
                self._server, camera.placed, lambda: np.asarray(camera.q), lambda: [source.latest()]
            )
        self._labels = LabelPlacer(self._server, self._drawing.labels)
        self.stopped = self.control_panel.run.stopped
        self.frames = 0  #: number of updates sent
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-viewer", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stops drawing and closes the port; the session continues."""
        self._stop.set()
        self.inset.close()
        if self.surgeon is not None:
            self.surgeon.close()
        self._thread.join(timeout=2.0)
        close_server(self._server)

    def _fit_panels(self) -> None:
        """Leave half of a small window to the picture."""
        windows = [browser.window for browser in self.picture.browsers.values() if browser.window > 0]
        wide = max(windows, default=NARROW + 1) > NARROW
        if wide == self._wide:
            return
        self._wide = wide
        self._gauges.panel.set_width(320 if wide else 195)
        self._server.gui.main_panel.set_width(280 if wide else 195)

    def _run(self) -> None:
        due = time.perf_counter()
        while not self._stop.is_set():
            self._frame(self.frames)
            self.frames += 1
            due = max(due + 1.0 / self.picture.rate(FRAME_RATE), time.perf_counter())
            self._stop.wait(due - time.perf_counter())

    def _frame(self, frame: int) -> None:
        tick = self._source.latest()
        with self._server.atomic():
            self.picture.at(float(tick["t"]))
            if self.picture.still and frame % FRAMES_PER_IDLE:
                return
            self._drawing.set_light(self.picture.light)
            self._drawing.show(tick)
            if self._bodies is not None:
                self._bodies.show()
            if self._task is not None:
                self._task.show()
            if self._camera is not None:
                self._drawing.show_ecm(self._camera.q)
            if self.soft is not None:
                self.soft.show()
            if self._clouds is not None:
                self._clouds.show(float(tick["t"]))
            self._video.show(getattr(self._source, "video", None))
            self._drawing.show_plane(getattr(self._source, "plane", None))
            self.control_panel.show(tick)
            self.control_panel.resize_ball(self._server, self.picture.scale)
            self._gauges.add(tick)
            slower = LIGHT_SLOWER if self.picture.light else 1
            if frame % (slower * FRAMES_PER_READOUT) == 0:
                self._fit_panels()
                now = self._source.controls
                over = not getattr(self._source, "running", True) and float(tick["t"]) > 0.0
                self._gauges.show(tick, self.control_panel.pause.value, now.stiffness_scale, now.damping_scale, over)
                if self._rates is not None:
                    self._rates.show()
                ball = self.control_panel.ball
                self._labels.show(np.array(ball.position), float(ball.radius))
            if frame % (slower * FRAMES_PER_PLOT) == 0:
                self._gauges.plot()
