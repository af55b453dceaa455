"""A simulated depth camera: exact depths of the visible surfaces, with the errors that were measured on a Kinect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.rigid import inverse
from palpate.sensing.lens import Image, Lens

RIM = 0.02
"""Relative step of the depth between neighbouring pixels that counts as the rim of an object [-]."""

_TABLE = 8  # size of the tables of random numbers, in pictures
_SHADES = 64  # shades of a colour


@dataclass(frozen=True)
class DepthErrors:
    """Errors of a structured-light depth camera.

    Such a camera measures a disparity, which is linear in 1/z. Noise and steps of the disparity are constant, so that
    those of the depth grow with its square. Defaults: K. Khoshelham and S. O. Elberink, "Accuracy and resolution of
    Kinect depth data for indoor mapping applications", Sensors 12, 2012, eqs. 9 to 13: 2.85e-5 / cm for a step of the
    disparity, and half a step for its standard deviation.
    """

    noise: float = 1.425e-3  #: standard deviation at a depth of 1 m [m]
    step: float = 2.85e-3  #: step between neighbouring depth values at a depth of 1 m; 0: no steps [m]
    dropout: float = 0.01  #: share of pixels without a measurement [-]
    rim_dropout: float = 0.3  #: the same at rims [-]
    flying: float = 0.3  #: share of the pixels at a rim in front of a farther surface that lie between both [-]
    grazing: float = 0.17  #: smallest cosine of the angle between ray and normal that gives a measurement [-]


NO_ERRORS = DepthErrors(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""An ideal camera."""


@dataclass(frozen=True)
class Body:
    """A rigid body that the camera can see."""

    name: str
    vertices: Array  #: (n, 3) in its own frame [m]
    triangles: npt.NDArray[np.int32]  #: (m, 3)
    color: tuple[int, int, int] = (150, 150, 150)  #: red, green, blue


@dataclass(frozen=True)
class DepthPicture:
    """One picture of a depth camera."""

    depth: Image  #: (rows, columns), NaN where nothing was measured [m]
    points: Image  #: (rows, columns, 3) in the camera's frame C, NaN where nothing was measured [m]
    body: npt.NDArray[np.int16]  #: (rows, columns) number of the visible body, -1: none; not known to a real camera
    colors: npt.NDArray[np.uint8]  #: (rows, columns, 3) red, green, blue

    @property
    def valid(self) -> npt.NDArray[np.bool_]:
        """(rows, columns) True where a depth was measured."""
        return np.isfinite(self.depth)


class SimulatedDepthCamera:
    """Takes depth pictures of bodies.

    Args:
        bodies: what there is to see.
        lens: intrinsic parameters.
        errors: errors of the measurement.
        seed: seed of the errors.
    """

    def __init__(
        self, bodies: Sequence[Body], lens: Lens | None = None, errors: DepthErrors | None = None, seed: int = 0
    ) -> None:
        self.bodies, self.lens, self.errors = tuple(bodies), lens or Lens(), errors or DepthErrors()
        k = self.lens
        self._image = _core.DepthImage(k.columns, k.rows, k.fx, k.fy, k.cx, k.cy, 0.25 * k.near)
        self._rng = np.random.default_rng(seed)
        n = _TABLE * k.columns * k.rows  # new random numbers for every picture would take longer than the picture
        self._normal = self._rng.standard_normal(n, dtype=np.float32)
        self._uniform = self._rng.random(n, dtype=np.float32)
        own = np.array([*(body.color for body in self.bodies), (0, 0, 0)])
        light = 0.35 + 0.65 * np.linspace(0.0, 1.0, _SHADES)
        shaded = (own[:, None] * light[:, None]).reshape(-1, 3).astype(np.uint8)  # (bodies * shades, 3)
        self._palette = np.pad(shaded, ((0, 0), (0, 1))).view(np.uint32).ravel()  # one word for a colour

    def take(self, X_WC: Array, poses_W: Sequence[Array]) -> DepthPicture:
        """A picture from the pose X_WC (4, 4) with the bodies at these poses (4, 4) in W [m]."""
        X_CW = inverse(X_WC)
        self._image.clear()
        for i, (body, X_WB) in enumerate(zip(self.bodies, poses_W, strict=True)):
            self._image.draw(body.vertices, body.triangles, X_CW @ X_WB, i)
        cosine, seen = self._image.cosine(), self._image.object()
        depth = self._measured(self._image.inverse_depth(), cosine)
        shade = _SHADES * (seen % (len(self.bodies) + 1)) + ((_SHADES - 1) * cosine).astype(np.int16)
        colors = self._palette.take(shade).view(np.uint8).reshape(*depth.shape, 4)[..., :3]
        return DepthPicture(depth, self.lens.points(depth), seen, colors)

    def _measured(self, w: Image, cosine: Image) -> Image:
        """Depth (rows, columns) [m] as measured, from the true inverse depth w [1/m]."""
        errors, lens = self.errors, self.lens
        normal, uniform = self._drawn(self._normal, w), self._drawn(self._uniform, w)
        # Noise and steps are constant in 1/z: sigma_z = z^2 sigma_(1/z).
        measured = w + np.float32(errors.noise) * normal
        lost = (w < 1.0 / lens.far) | (w > 1.0 / lens.near) | (cosine < errors.grazing) | (uniform < errors.dropout)
        behind = _farthest_neighbour(w)
        rim = np.flatnonzero(w - behind > RIM * w)
        front, back, chance = w.flat[rim], behind.flat[rim], self._rng.random(len(rim), dtype=np.float32)
        share = self._rng.random(len(rim), dtype=np.float32)
        flies = (back > 0.0) & (chance > 1.0 - errors.flying)
        measured.flat[rim[flies]] = (back + share * (front - back))[flies]
        lost.flat[rim[chance < errors.rim_dropout]] = True
        if errors.step > 0.0:
            np.rint(measured / np.float32(errors.step), out=measured)
            measured *= np.float32(errors.step)
        lost |= measured < 1.0 / lens.far
        measured[lost] = np.nan
        return np.asarray(np.float32(1.0) / measured)

    def _drawn(self, table: Image, like: Image) -> Image:
        """Random numbers in the shape of an image: a part of the table that begins at a random place."""
        start = int(self._rng.integers(len(table) - like.size + 1))
        return table[start : start + like.size].reshape(like.shape)


def _farthest_neighbour(w: Image) -> Image:
    """Smallest of w and its four neighbours; w at the border of the image is its own neighbour."""
    found = w.copy()
    np.minimum(found[1:], w[:-1], out=found[1:])
    np.minimum(found[:-1], w[1:], out=found[:-1])
    np.minimum(found[:, 1:], w[:, :-1], out=found[:, 1:])
    np.minimum(found[:, :-1], w[:, 1:], out=found[:, :-1])
    return found
