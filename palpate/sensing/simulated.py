"""A simulated depth camera as a source of clouds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.base.arrays import Array
from palpate.scene.sensors import SimulatedCameraSection
from palpate.sensing.depth_camera import DepthErrors, DepthPicture, SimulatedDepthCamera
from palpate.sensing.lens import Lens
from palpate.sensing.source import CloudFrame
from palpate.sensing.world import SeenWorld


class SimulatedCameraSource:
    """Frames of a simulated camera at its rate.

    Args:
        world: what there is to see.
        section: lens and errors.
        rate: frames per second [Hz].
        X_WC: pose (4, 4) of the camera in W at the moment of a frame [m].
        seed: seed of the errors.
    """

    def __init__(
        self, world: SeenWorld, section: SimulatedCameraSection, rate: float, X_WC: Callable[[], Array], seed: int = 0
    ) -> None:
        self._world, self._X_WC, self._period, self._next = world, X_WC, 1.0 / rate, -np.inf
        self.camera = SimulatedDepthCamera(world.bodies, lens(section), errors(section), seed)
        self.picture: DepthPicture | None = None  #: the newest picture

    def latest(self, now: float) -> CloudFrame | None:
        """A picture once its time has come; it takes about 10 ms for 640 x 480 pixels."""
        if now < self._next - 1e-9:
            return None
        self._next = now + self._period if now - self._next > self._period else self._next + self._period
        X_WC = self._X_WC()
        picture = self.picture = self.camera.take(X_WC, self._world.poses())
        return CloudFrame(picture.points, now, X_WC, picture.colors.reshape(-1, 3))

    def close(self) -> None:
        """Nothing is open."""


def lens(section: SimulatedCameraSection) -> Lens:
    """Intrinsic parameters of a section; the principal point is in the middle of the image."""
    columns, rows = section.columns, section.rows
    focal = 0.5 * columns / float(np.tan(0.5 * np.radians(section.width_deg)))
    middle = 0.5 * (columns - 1), 0.5 * (rows - 1)
    return Lens(columns, rows, focal, focal, *middle, section.near, section.far)


def errors(section: SimulatedCameraSection) -> DepthErrors:
    """Errors of a section."""
    noise, step = 1e-3 * section.noise_mm, 1e-3 * section.step_mm
    return DepthErrors(noise, step, dropout=section.dropout, flying=section.flying)
