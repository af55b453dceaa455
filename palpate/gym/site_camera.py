"""The endoscope of a simulated remote site: pictures of its instruments and objects, without a graphics card."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec

import numpy as np

from palpate import _network
from palpate.base.errors import MissingExtraError, PalpateError
from palpate.gym.picture import Eye
from palpate.record.ticks import TICK, Ticks
from palpate.scene.rig import Rig
from palpate.session.network.jpeg import packed, require_packer
from palpate.session.network.video import RATE, Picture

SIZE = (480, 640)
"""Height and width of a picture [pixels]."""


class SiteCamera:
    """What the left eye of the scene's endoscope sees at a simulated site: objects at rest, where the site has them.

    Args:
        rigs: those of all pairs.
        packets: the bytes of the newest datagram of each pair's follower, with the pose of its tool; none while
            nobody looks, so that nothing is drawn.

    Raises:
        MissingExtraError: nothing here draws, or packs pictures as JPEG.
    """

    def __init__(self, rigs: Sequence[Rig], packets: Callable[[], Sequence[bytes]]) -> None:
        if find_spec("moderngl") is None:
            raise MissingExtraError("moderngl, which draws the site,", "learning")
        require_packer()
        self._rigs, self._packets = rigs, packets
        section = rigs[0].scene.remote
        self._shift = np.zeros(3) if section is None else np.asarray(section.site_shift, float)
        self._q = [np.array(one.arms.q_follower0) for one in rigs]

    def pictures(self, stopped: threading.Event, tell: Callable[[str], None]) -> Iterator[Picture]:
        """Yield a picture at a fixed rate, until stopped."""
        try:
            eye = Eye(self._rigs, SIZE, self._shift)
        except PalpateError as error:
            tell(str(error))
            return
        due = time.monotonic()
        try:
            while not stopped.wait(max(due - time.monotonic(), 0.0)):
                due = max(due + 1.0 / RATE, time.monotonic())
                ticks, t = np.zeros((1, len(self._rigs)), TICK), time.monotonic()
                if len(packets := self._packets()) < len(self._rigs):
                    continue
                for k, data in enumerate(packets):
                    self._place(ticks[:, k], k, _network.decode(data))
                yield Picture(packed(eye.pictures(ticks, [None])[0]), t)
        finally:
            eye.close()

    def _place(self, tick: Ticks, k: int, state: _network.Datagram | None) -> None:
        """Joints of the instrument of pair k, which puts its tip at the pose of a datagram, near the joints before."""
        arms = self._rigs[k].arms
        if state is not None and state.t > 0.0:
            X_BT = np.linalg.inv(arms.X_WB) @ np.asarray(state.X)
            self._q[k], _ = arms.follower.ik_nearest(X_BT, self._q[k], restarts=0)
            tick["jaw"] = state.jaw
        tick["q_follower"][0, : len(self._q[k])] = self._q[k]
