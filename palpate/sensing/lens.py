"""Intrinsic parameters of a depth camera."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

Image = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Lens:
    """A pinhole camera with the optical frame C of ROS: z forward, x right, y down.

    The centre of pixel (0, 0) has the image coordinates (0, 0). The defaults are those of a Kinect.
    """

    columns: int = 640
    rows: int = 480
    fx: float = 525.0  #: focal length [pixel]
    fy: float = 525.0  #: focal length [pixel]
    cx: float = 319.5  #: principal point [pixel]
    cy: float = 239.5  #: principal point [pixel]
    near: float = 0.2  #: smallest measured depth [m]
    far: float = 4.0  #: largest measured depth [m]

    @cached_property
    def rays(self) -> Image:
        """Slopes (rows * columns, 3) of the rays of all pixels: x/z, y/z and 1."""
        u, v = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        slopes = np.stack([(u - self.cx) / self.fx, (v - self.cy) / self.fy, np.ones(u.shape)], axis=-1)
        return np.asarray(slopes.reshape(-1, 3), dtype=np.float32)

    def points(self, depth: Image) -> Image:
        """Points (rows, columns, 3) in C of a depth image (rows, columns), not finite where it is not [m]."""
        return np.asarray((self.rays * depth.reshape(-1, 1)).reshape(*depth.shape, 3))

    @property
    def K(self) -> npt.NDArray[np.float64]:
        """Camera matrix (3, 3) [pixel]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])
