"""The surface through a point cloud (core/palpate/clouds/point_surface.hpp)."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.errors import PalpateWarning, SurfaceError
from palpate.world.clouds import PointCloud
from palpate.world.clouds.neighbourhoods import Sampling, layer_gap, outward_normals, sampling
from palpate.world.clouds.table import THICKNESS
from palpate.world.surfaces.surface import Surface, Triangles, length

if TYPE_CHECKING:
    from palpate import _tissue

_LEAST = 30  # points of a surface at least
_AVERAGED = 11.0  # support over the root of noise times spacing [-]
_LINE = 0.05  # extent across a line, divided by that along it, below which the points are a line


@dataclass(frozen=True)
class Scales:
    """Lengths that shape the surface through a cloud [m]."""

    voxel: float  #: points in one cube with this side are averaged
    support: float  #: radius within which points shape the surface
    bridge: float  #: gaps between points narrower than twice this length are closed

    @classmethod
    def of(cls, found: Sampling) -> Scales:
        """The scales for a spacing and a noise [m].

        The support holds enough points to average their noise: 3 spacings, and more in proportion to the root of noise
        times spacing. The error that noise leaves falls with spacing times noise over the support, that by curvature
        grows with the support; at this length their sum is smallest on organs. The voxels bound the number of points
        within the support, and with it the time of a query.
        """
        spacing = max(found.spacing, 1e-4)
        support = 3.0 * spacing + _AVERAGED * math.sqrt(found.noise * spacing)
        voxel = max(spacing, (3.0 * spacing + 5.0 * found.noise) / 4.0)
        return cls(voxel, support, 2.0 * voxel)


class PointSurface(Surface):
    """The surface through a point cloud, as a depth camera or a scanner sees it.

    Normals are those of the cloud, or those of the planes through the neighbours, oriented towards its viewpoint.
    Without normals and viewpoint they are oriented outwards along the surface. Behind the points lies a solid layer;
    the surface ends at rims and at holes wider than twice ``bridge``.

    Args:
        cloud: the points.
        support: radius within which points shape the surface [m]; larger values smooth more. Default: 3 spacings of
            the points plus 11 roots of noise times spacing, both measured.
        bridge: half the width of holes that are closed [m]; default: 2 spacings.
        thickness: thickness of the solid layer behind the points [m].

    Raises:
        SurfaceError: the points are too few or lie on a line, or a length is not positive.
    """

    core: _tissue.PointSurface
    layer_gap: float  #: distance between two layers of points that become one surface; 0: there is one layer [m]

    def __init__(
        self,
        cloud: PointCloud,
        *,
        support: float | None = None,
        bridge: float | None = None,
        thickness: float = THICKNESS,
    ) -> None:
        from palpate import _tissue

        self.name, self.cloud = cloud.name, cloud
        _require_surface(cloud)
        self.sampling = sampling(cloud.points)
        usual = Scales.of(self.sampling)
        self.scales = Scales(
            usual.voxel,
            usual.support if support is None else length("support of a cloud", support),
            usual.bridge if bridge is None else length("bridge of a cloud", bridge),
        )
        normals = cloud.normals
        self.layer_gap = layer_gap(cloud.points, self.scales.support, normals)
        if self.layer_gap > 0.0:
            _warn_of_layers(self)
        if normals is None and cloud.viewpoint is None:
            normals = _unoriented(cloud, self.scales)
        s = self.scales
        self.core = _tissue.PointSurface(
            np.ascontiguousarray(cloud.points), None if normals is None else np.ascontiguousarray(normals),
            None if normals is not None else cloud.viewpoint, s.voxel, s.support, s.bridge,
            length("thickness of a cloud", thickness),
        )  # fmt: skip
        if len(self.core) < _LEAST:
            raise SurfaceError(
                f"only {len(self.core)} of {len(cloud):,} points lie on a surface",
                where=cloud.name,
                why="the others have too few neighbours, or are seen at a grazing angle",
                mend="record a denser cloud, or give a larger support",
            )

    @property
    def recommended_radius(self) -> float:
        """Smallest radius of the tool's sphere that does not feel single points [m]: 2 spacings, and the noise."""
        return max(2.0 * self.sampling.spacing, self.sampling.noise)

    def __str__(self) -> str:
        """Number of points, spacing, noise and the radius that they ask for."""
        s = self.sampling
        points = f"{len(self.cloud):,} points every {1e3 * s.spacing:.2g} mm"
        text = f"cloud, {points}, noise {1e3 * s.noise:.2g} mm; radius {1e3 * self.recommended_radius:.2g} mm or more"
        return text + (f"; two layers {1e3 * self.layer_gap:.2g} mm apart, as one" if self.layer_gap > 0.0 else "")

    def _drawing(self) -> tuple[Array, Triangles]:
        """One small triangle at each averaged point, in the plane of the surface."""
        p, n, _ = self.core.averaged()
        return drawn_points(p, n, 0.9 * self.scales.voxel)


class LiveCloud(Surface):
    """The surface of a stream of clouds before its first frame: nothing can be touched.

    Args:
        thickness: thickness of the solid layer behind the points [m].
        name: name in plots and messages.

    Raises:
        SurfaceError: the thickness is not a positive length.
    """

    core: _tissue.PointSurface

    def __init__(self, thickness: float = THICKNESS, *, name: str = "cloud") -> None:
        from palpate import _tissue

        self.name, self.thickness = name, length("thickness of a cloud", thickness)
        self.core = _tissue.PointSurface(np.empty((0, 3)), thickness=self.thickness)

    def __str__(self) -> str:
        """Kind, for messages."""
        return "cloud of a sensor"

    def _drawing(self) -> tuple[Array, Triangles]:
        """One triangle of a millimetre, because there is no point yet."""
        return drawn_points(np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), 1e-3)


def drawn_points(p: Array, n: Array, size: float) -> tuple[Array, Triangles]:
    """Triangles of a size [m] at points (N, 3) with normals (N, 3)."""
    helper = np.where(np.abs(n[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    u = np.cross(n, helper)
    u /= np.maximum(np.linalg.norm(u, axis=1, keepdims=True), 1e-300)
    v = np.cross(n, u)
    corners = np.stack([p + size * (np.cos(a) * u + np.sin(a) * v) for a in 2.0 * np.pi / 3.0 * np.arange(3)], axis=1)
    return corners.reshape(-1, 3), np.arange(3 * len(p), dtype=np.int32).reshape(-1, 3)


def _require_surface(cloud: PointCloud) -> None:
    if len(cloud) < _LEAST:
        what = f"{len(cloud)} points are no surface" if len(cloud) > 1 else "one point is no surface"
        raise SurfaceError(what, where=cloud.name, mend=f"give {_LEAST} points or more")
    centred = cloud.points - cloud.points.mean(axis=0)
    values = np.sqrt(np.maximum(np.linalg.eigvalsh(centred.T @ centred), 0.0))
    if values[1] < _LINE * values[2]:
        raise SurfaceError("the points lie on a line", where=cloud.name, mend="move the sensor across the surface")


def _warn_of_layers(surface: PointSurface) -> None:
    gap, support = 1e3 * surface.layer_gap, 1e3 * surface.scales.support
    warnings.warn(
        PalpateWarning(
            f"two layers of points, {gap:.2g} mm apart, are felt as one surface between them",
            where=surface.name,
            why=f"points within {support:.2g} mm shape the surface together, if their normals do not oppose each other",
            mend="leave one layer out; register the views better; or give normals, if one layer is a back",
        ),
        stacklevel=4,
    )


def _unoriented(cloud: PointCloud, scales: Scales) -> npt.NDArray[np.float64]:
    normals = outward_normals(cloud.points, 0.7 * scales.support)
    away = cloud.points - cloud.points.mean(axis=0)
    outwards = np.einsum("ni,ni->n", normals, away) / np.maximum(np.linalg.norm(away, axis=1), 1e-300)
    if abs(float(outwards.mean())) < 0.1:
        warnings.warn(
            PalpateWarning(
                "it is not certain which side of the cloud is outside",
                where=cloud.name,
                why="the cloud is flat, and has neither normals nor the position of its sensor",
                mend="give viewpoint: the position (3,) from which it was seen [m]",
            ),
            stacklevel=4,
        )
    return normals
