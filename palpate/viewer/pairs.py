"""The viewer of several pairs: all arms, each in the colour of its pair, and a gauge and a handle a hand."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from functools import partial
from html import escape
from typing import Any, cast

import numpy as np
import viser

from palpate.base.arrays import Array
from palpate.record.ticks import Ticks
from palpate.session import PairsSession, Session
from palpate.session.console import PEDALS, Console
from palpate.viewer import views
from palpate.viewer.arms import Color
from palpate.viewer.bodies import BodiesDrawing, TaskWords, jaw_slider
from palpate.viewer.control_panel import BALL, REACH
from palpate.viewer.controls import set_value
from palpate.viewer.drawing import Drawing
from palpate.viewer.live import FRAME_RATE, FRAMES_PER_PLOT, FRAMES_PER_READOUT, LIGHT_SLOWER
from palpate.viewer.pair_gauges import PairGauges
from palpate.viewer.picture import Picture
from palpate.viewer.run_buttons import RunButtons, Runner
from palpate.viewer.server import close_server, open_server, url
from palpate.viewer.soft_objects import SoftObjects
from palpate.viewer.stage import Stage
from palpate.viewer.surgeon import SurgeonView
from palpate.viewer.video import VideoPanel

COLORS: tuple[Color, ...] = (
    (38, 110, 200), (222, 120, 20), (40, 150, 90), (150, 70, 180),
    (190, 40, 60), (90, 90, 90), (0, 150, 160), (150, 120, 20),
)  # fmt: skip
"""Colour of each pair, in the order of the scene."""


_ON_DEVICE = '<div style="padding:2px 10px;font-size:12px;overflow-wrap:anywhere">on the device {}</div>'


class Within:
    """The interface of a scene, with all names below one node."""

    def __init__(self, scene: viser.SceneApi, root: str) -> None:
        self._scene, self._root = scene, root

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._scene, name)
        if not name.startswith("add_"):
            return found
        return lambda node, *args, **kwargs: found(f"{self._root}{node}", *args, **kwargs)


class Handle:
    """The ball that drags one hand, and the switch of its path."""

    def __init__(self, server: viser.ViserServer, name: str, stage: Stage, source: Session, color: Color) -> None:
        self._source, self._stage = source, stage
        self._offset, self._offset_grab, self._p_grab = np.zeros(3), np.zeros(3), np.zeros(3)
        with server.gui.add_folder(name):
            led = stage.device is not None  # the hand is on the device
            if stage.device is not None:
                server.gui.add_html(_ON_DEVICE.format(escape(stage.device.name)))
            hint = "Off: the hand stops on its path"
            self.path = server.gui.add_checkbox("follow the path", True, hint=hint, visible=not led)
            if source.scene.bodies:
                self.jaws = jaw_slider(server.gui, self._pinch)
        self.ball = server.scene.add_icosphere(
            f"/{name}/hand", 1.5 * BALL, color, opacity=0.6, cast_shadow=False, visible=not led
        )
        self.ball.on_drag("left")(self._drag)
        self.path.on_update(lambda _: self.send())

    def show(self, tick: Ticks) -> None:
        """Moves the ball to the hand's intended position."""
        X_WL = self._stage.leader.X_WA
        self.ball.position = X_WL[:3, :3] @ tick["p_hand_L"] + X_WL[:3, 3]

    def send(self) -> None:
        """Sends the values to the loop."""
        self._source.change(hold=not self.path.value, p_hand_offset_W=self._offset)

    def _pinch(self, angle: float) -> None:
        self._take_over()
        self._source.change(hold=True, p_hand_offset_W=self._offset, hand_pinch=angle)

    def _take_over(self) -> None:
        """The person goes on from where a simulated operator has led the hand."""
        self._offset = np.array(self._source.controls.p_hand_offset_W)
        set_value(self.path, False)

    def move(self, offset_W: Array) -> None:
        """Displaces the hand from its path (3,) [m]."""
        set_value(self.path, False)
        self._offset = np.clip(offset_W, -REACH, REACH)
        self.send()

    async def _drag(self, event: viser.SceneNodeDragEvent[viser.IcosphereHandle]) -> None:
        if event.phase == "start":
            self._take_over()
            self._p_grab, self._offset_grab = np.array(event.start_position), self._offset
        self.move(self._offset_grab + np.array(event.end_position) - self._p_grab)


class Pedals:
    """The pedals of the console, as check boxes in a folder."""

    def __init__(self, gui: viser.GuiApi, console: Console) -> None:
        with gui.add_folder("Pedals"):
            self.boxes = {
                name: gui.add_checkbox(name, False, hint=PEDALS[name]) for name in ("clutch", "camera", "coag")
            }
        for name, box in self.boxes.items():
            box.on_update(partial(self._send, console, name))

    def _send(self, console: Console, pedal: str, _: object) -> None:
        console.set(pedal, self.boxes[pedal].value, "viewer")


class PairsViewer:
    """A viewer of all pairs of a scene; it reads the newest ticks and never waits for a loop.

    Args:
        sources: running session of each pair, by name.
        stages: what is drawn of each pair; the objects are those of the first.
        title: title of the page.
        runner: what the buttons run, step and stop; None offers only a pause.
        seat: the session whose console has the pedals and whose camera gives the surgeon's view; None: neither.
        rates: rows of the panel of rates (`palpate.session.rates`); asked once a second.
        handle_distance: distance of two handles below which a warning appears [m].
        host, port, server: as for `LiveViewer`.

    Raises:
        PortError: the port cannot be used.
    """

    def __init__(
        self,
        sources: Mapping[str, Session],
        stages: Mapping[str, Stage],
        title: str,
        runner: Runner | None = None,
        seat: PairsSession | None = None,
        rates: Callable[[], list[Any]] | None = None,
        handle_distance: float = 0.0,
        host: str = "127.0.0.1",
        port: int = 8080,
        server: viser.ViserServer | None = None,
    ) -> None:
        self._sources = dict(sources)
        self._server = open_server(host, port, title) if server is None else server
        self.url = url(self._server)
        first = next(iter(stages.values()))
        every = [stage.seen if len(stage.seen) else stage.focus[None] for stage in stages.values()]
        self._seen = np.concatenate(every)
        views.Framing(self._server, partial(views.overview_of, self._seen))
        colors = dict(zip(stages, COLORS, strict=False))
        self.picture = Picture(self._server)
        self.drawings = {
            name: Drawing(
                cast("viser.SceneApi", Within(self.picture.scene, f"/{name}")), stage, stage is first, colors[name]
            )
            for name, stage in stages.items()
        }
        devices = {name: drawing.device for name, drawing in self.drawings.items() if drawing.device is not None}
        self._gauges = PairGauges(self._server, dict(stages), devices, colors, handle_distance, rates)
        gui = self._server.gui
        gui.set_panel_label(title)
        self.handles = {n: Handle(self._server, n, stage, sources[n], colors[n]) for n, stage in stages.items()}
        self.pedals = None if seat is None else Pedals(gui, seat.console)
        self._camera = None if seat is None else seat.camera
        self.surgeon = None
        if self._camera is not None:
            camera = self._camera
            with gui.add_folder("Endoscope"):
                self.surgeon = SurgeonView(self._server, camera.placed, lambda: camera.q, self._ticks)
        name, stage = next(iter(stages.items()))
        world, words = getattr(seat, "world", None), getattr(seat, "task_words", None)
        self._bodies = None if world is None else BodiesDrawing(self.picture.scene, stage.solids, world.drawn)
        self._task = None if words is None else TaskWords(gui, words)
        self._video = VideoPanel(gui)
        self.soft = None
        if any(obj.soft for obj in stage.objects):
            self.soft = SoftObjects(gui, stage, self.drawings[name], sources[name])
        with gui.add_folder("Run"):
            self.run = RunButtons(gui, runner, bool(getattr(runner, "recording", False)))
            self.run.pause.on_update(lambda _: self._pause())
        gui.main_panel.dock_right()
        gui.main_panel.set_width(240)
        self.stopped = self.run.stopped
        self.frames = 0  #: number of updates sent
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-viewer", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stops drawing and closes the port; the sessions continue."""
        self._stop.set()
        if self.surgeon is not None:
            self.surgeon.close()
        self._thread.join(timeout=2.0)
        close_server(self._server)

    def _pause(self) -> None:
        for source in self._sources.values():
            source.change(paused=self.run.pause.value)

    def _ticks(self) -> list[Ticks]:
        return [source.latest() for source in self._sources.values()]

    def _run(self) -> None:
        due = time.perf_counter()
        while not self._stop.is_set():
            self._frame()
            due = max(due + 1.0 / self.picture.rate(FRAME_RATE), time.perf_counter())
            self._stop.wait(due - time.perf_counter())

    def _frame(self) -> None:
        ticks = {name: source.latest() for name, source in self._sources.items()}
        with self._server.atomic():
            self.picture.at(float(next(iter(ticks.values()))["t"]))
            for drawing in self.drawings.values():
                drawing.set_light(self.picture.light)
            presses: list[Any] = []
            for name in reversed(ticks):  # the first pair draws the objects, dented by all tools
                presses.append(self.drawings[name].show(ticks[name], presses))
                self.handles[name].show(ticks[name])
                self.drawings[name].show_plane(getattr(self._sources[name], "plane", None))
            if self._bodies is not None:
                self._bodies.show()
            if self._task is not None:
                self._task.show()
            if self._camera is not None:
                next(iter(self.drawings.values())).show_ecm(self._camera.q)
            if self.soft is not None:
                self.soft.show()
            self._video.show(next(iter(self._sources.values())).video)  # one camera for all pairs
            self._gauges.add(ticks)
            slower = LIGHT_SLOWER if self.picture.light else 1
            if self.frames % (slower * FRAMES_PER_READOUT) == 0:
                over = [n for n, s in self._sources.items() if not getattr(s, "running", True) and ticks[n]["t"] > 0.0]
                self._gauges.show(ticks, self.run.pause.value, over)
            if self.frames % (slower * FRAMES_PER_PLOT) == 0:
                self._gauges.plot()
        self.frames += 1
