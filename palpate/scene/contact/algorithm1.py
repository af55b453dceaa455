"""The paper's Algorithm 1 for one position of the tool, line by line, with the code of method ``paper-alg1``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy.typing as npt

from palpate import _collision
from palpate.base.arrays import Array
from palpate.base.arrays.checks import positive, vector
from palpate.scene.contact.rendering import SurfaceLike, snapshot_of


@dataclass(frozen=True)
class Trace:
    """The values of Algorithm 1 after each of its lines. World frame W, SI units; ``print`` shows them."""

    collision: bool  #: line 1
    points: Array  #: line 2: (z, 3) collision points p_i, z <= 15 [m]
    normals: Array  #: line 3: (z, 3) unit vectors from the triangle to the sphere's centre
    depths: Array  #: (z,) overlap of each point along its normal [m]
    normal: Array  #: line 4: (3,) mean unit normal n
    delta_x_total: Array  #: line 5: (3,) [m]
    v_total: Array  #: line 6: (3,) [m/s]
    delta_x: Array  #: line 7: (3,) along n [m]
    v: Array  #: line 8: (3,) along n [m/s]
    force_spring: Array  #: line 9: (3,) K delta_x [N]
    force_damping: Array  #: line 9: (3,) -B v [N]
    force: Array  #: line 9: (3,) total force of the surface on the tool; zero without a collision [N]

    def __str__(self) -> str:
        """The lines of the algorithm with their values."""
        if not self.collision:
            return "1 no collision: F = 0"
        mm, mm_s = 1e3, 1e3
        rows = [
            ("1", "collision", "true"),
            ("2", f"{len(self.points)} points p_i", _rows(self.points * mm, "mm")),
            ("3", "normals n_i", _rows(self.normals, "")),
            ("4", "n = sum n_i / |sum n_i|", _row(self.normal, "")),
            ("5", "delta_x_total = x_d - x", _row(self.delta_x_total * mm, "mm")),
            ("6", "v_total", _row(self.v_total * mm_s, "mm/s")),
            ("7", "delta_x = (n . delta_x_total) n", _row(self.delta_x * mm, "mm")),
            ("8", "v = (n . v_total) n", _row(self.v * mm_s, "mm/s")),
            ("9", "F = K delta_x - B v", _row(self.force, "N")),
        ]
        return "\n".join(f"{line} {law:<32} {value}" for line, law, value in rows)


def trace_algorithm1(
    surface: SurfaceLike,
    tip: npt.ArrayLike,
    *,
    radius: float,
    stiffness: float | npt.ArrayLike,
    damping: float | npt.ArrayLike = 0.0,
    velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
    last_normal: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> Trace:
    """Run Algorithm 1 once for a given tool tip.

    Args:
        surface: as in ``palpate.contact.render``.
        tip: (3,) p_WT, the centre of the spherical proxy region [m].
        radius: radius of the spherical proxy region [m].
        stiffness: K, one number or one per axis of W [N/m].
        damping: B, likewise [N s/m].
        velocity: (3,) v_WT of the tool [m/s].
        last_normal: (3,) n of the previous collision, used if the normals cancel each other.

    Raises:
        ValueError: an argument is not valid; the message names it, its value and the requirement.
        MeshError: the vertices and triangles do not form a mesh.
    """
    snapshot = snapshot_of(surface, stiffness=stiffness, damping=damping)
    positive("radius", radius, "m")
    vectors = [vector(*v) for v in (("tip", tip), ("velocity", velocity), ("last_normal", last_normal))]
    p_WT, v_WT, n_last = vectors
    return Trace(**_collision.trace_algorithm1(snapshot, p_WT, v_WT, radius, n_last))


def _row(v: Array, unit: str) -> str:
    return f"({', '.join(f'{x:+.4f}' for x in v + 0.0)}) {unit}".rstrip()


def _rows(m: Array, unit: str) -> str:
    shown = " ".join(_row(v, "") for v in m[:3])
    more = f" and {len(m) - 3} more" if len(m) > 3 else ""
    return f"{shown}{more} {unit}".rstrip()
