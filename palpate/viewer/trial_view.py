"""What a participant sees in a trial: the scene, the ball to drag, the way points, the instruction, and force cues."""

from __future__ import annotations

import threading
import time
from html import escape

import numpy as np
import viser

from palpate.base.arrays import Array
from palpate.record.ticks import Ticks
from palpate.session import Session
from palpate.viewer.control_panel import HandBall
from palpate.viewer.cue import Cues, force_of
from palpate.viewer.drawing import Drawing
from palpate.viewer.live import FRAME_RATE
from palpate.viewer.stage import Stage
from palpate.viewer.surgeon import SurgeonView

_READOUT = 3  # frames between two updates of bar and tone
_MARK, _LINE = (255, 140, 20), 3.0
_BAR = (
    '<div style="padding:4px 10px"><div style="font-size:11px;opacity:.65">force</div>'
    '<div style="height:16px;background:#8883"><div id="palpate-cue-bar" '
    'style="height:16px;width:{:.1f}%;background:#e12626"></div></div></div>'
)
_TONE = '<div id="palpate-tone" data-hz="{:.1f}" style="display:none"></div>'


class TrialView:
    """The view of one trial on an open server; `close` leaves the server empty for the next one.

    Args:
        server: an open server.
        session: the session of the trial, not yet started.
        stage: what is drawn.
        cues: force cues of the condition.
        points: (m, 3) way points in W [m].
        near: radius of the marks at the way points [m].
        words: instruction.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        session: Session,
        stage: Stage,
        cues: Cues,
        points: Array,
        near: float,
        words: str,
    ) -> None:
        self._server, self._session, self._stage, self._cues = server, session, stage, cues
        self._drawing = Drawing(server.scene, stage, cues=cues)
        for arrow in (self._drawing.deflection, self._drawing.force_body, self._drawing.force_spatial):
            arrow.enabled = False  # they would show the force in every condition
        self._hand = HandBall(server, stage, session)
        self.ball = self._hand.ball
        for k, point in enumerate(points):
            server.scene.add_icosphere(f"/task/{k}", near, _MARK, opacity=0.35, position=point, cast_shadow=False)
        if len(points) > 1:
            pairs = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
            server.scene.add_line_segments("/task/path", pairs, _MARK, thickness=_LINE)
        self._folder = server.gui.add_folder("Trial")
        with self._folder:
            server.gui.add_html(
                f'<div style="padding:4px 10px;font-size:14px" id="palpate-instruction">{escape(words)}</div>'
            )
            self.give_up = server.gui.add_button("Stop this trial", hint="The trial is repeated later")
            self._bar = server.gui.add_html(_BAR.format(0.0), visible=cues.bar > 0.0)
            self._tone = server.gui.add_html(_TONE.format(0.0))
            self._surgeon = self._surgeons_view()
        self.frames = 0
        """Number of updates sent."""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="palpate-trial", daemon=True)
        self._thread.start()

    def _surgeons_view(self) -> SurgeonView | None:
        camera = getattr(self._session, "camera", None)
        if camera is None:
            return None
        return SurgeonView(
            self._server, camera.placed, lambda: np.asarray(camera.q), lambda: [self._session.latest()],
            lambda tick: self._cues.bar_share(force_of(tick), self._stage.force_cap),
        )  # fmt: skip

    def close(self) -> None:
        """End drawing and remove everything that was drawn."""
        if self._surgeon is not None:
            self._surgeon.close()
        self._stop.set()
        self._thread.join(timeout=5.0)
        self._folder.remove()
        self._server.scene.reset()

    def _run(self) -> None:
        while not self._stop.is_set():
            began = time.perf_counter()
            self._show(self._session.latest(), self.frames)
            self.frames += 1
            self._stop.wait(max(0.0, 1.0 / FRAME_RATE - (time.perf_counter() - began)))

    def _show(self, tick: Ticks, frame: int) -> None:
        with self._server.atomic():
            self._drawing.show(tick)
            self._hand.show(tick)
            self._hand.resize_ball(self._server)
            if frame % _READOUT == 0:
                force, cap = force_of(tick), self._stage.force_cap
                if self._cues.bar > 0.0:
                    self._bar.content = _BAR.format(100.0 * self._cues.bar_share(force, cap))
                if self._cues.tone > 0.0:
                    self._tone.content = _TONE.format(self._cues.tone_Hz(force, cap))
