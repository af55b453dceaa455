"""The work of ``palpate study contact``."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from functools import lru_cache
from itertools import islice
from typing import NamedTuple, cast

import numpy as np

from palpate import _collision, _core
from palpate.base.arrays import Array
from palpate.base.errors import PalpateWarning
from palpate.base.sweep import Axis, sweep
from palpate.base.sweep.grid import Point
from palpate.scene.contact.judging import PATHS, RADIUS, judge
from palpate.scene.contact_method import METHODS
from palpate.world.mesh import Mesh
from palpate.world.shapes.analytic import SHAPES, Box, Shape
from palpate.world.shapes.paths import RATE, ToolPath, tool_path
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.contact.result import GrownPlanes, Measured, Row, StudyResult

TRIANGLES, LARGE = (1_000, 10_000, 100_000), 1_000_000
SWEPT = 10_000  # triangles of the meshes for penetration and approach
PENETRATIONS = (0.25e-3, 0.5e-3, 1e-3, 1.5e-3, 1.9e-3, 2.5e-3, 3e-3, 3.5e-3, 3.9e-3, 4.5e-3, 6e-3)  # r - phi [m]
APPROACHES = (0.0, 15.0, 30.0, 45.0, 60.0, 75.0)  # angles of the path to the surface's normal [deg]
PLACES = 8  # number of places and headings per angle of approach
SPEED, PRESSED = 0.05, 1e-3  # speed of an approach [m/s]; r - phi at its end [m]
POINTS, SPREADS = (3, 4, 6, 9, 15), (0.1e-3, 0.2e-3, 0.4e-3, 0.8e-3, 1.6e-3)  # points of a grown plane; diameters [m]
NOISES, DRAWS = (1e-6, 10e-6, 100e-6), 400  # noise of the points [m]; planes per figure


class UpperFace(Box):
    """A box or plate that is pressed on its upper face; the reference is valid at any depth, even below the bottom."""

    def distance(self, points: Array) -> tuple[Array, Array]:
        """Signed distance (n,) [m] to the plane of the face, and its normals (n, 3)."""
        return points[:, 2] - self.half[2], np.tile([0.0, 0.0, 1.0], (len(points), 1))

    def curve(self, s: Array, offset: float) -> Array:
        """A loop (n, 3) above or below the face at the distance ``offset`` [m]."""
        return np.asarray(super().curve(s, -1.0) + np.array([0.0, 0.0, 1.0 + offset]))


PRESSED_FROM_ABOVE = {"box": UpperFace(), "plate": UpperFace((60e-3, 60e-3, 1e-3))}


def run(
    triangles: Iterable[int] = TRIANGLES,
    sweep: Sweeper = sweep,
    shapes: Iterable[str] = tuple(SHAPES),
    methods: Iterable[str] = METHODS,
) -> StudyResult:
    """All results: ``rows`` of the methods and ``planes`` grown through points."""
    tabled, path = set(triangles), {name: motion.path for name, motion in motions().items()}
    grid = {
        "shape": Axis(shapes),
        "size": Axis(sorted({*tabled, SWEPT}), "", "triangles asked for"),
        "way": Axis(path, "", "path of the tool"),
        "method": Axis(methods, "", "contact method"),
    }
    swept = sweep(
        experiment, grid, where=lambda p: p["size"] in tabled if path[p["way"]] in PATHS else p["size"] == SWEPT
    )
    drop = {"size", "way"}
    rows = [{key: value for key, value in row.items() if key not in drop} for row in swept.rows()]
    return {"rows": cast(list[Row], rows), "planes": list(grown_planes())}


class ToolMotion(NamedTuple):
    """A prescribed motion of the tool over a shape."""

    path: str
    """``shallow`` or ``deep`` as in the benchmark, ``penetration`` or ``approach``."""
    penetration: float
    """r - phi during the slide or at the end of the approach [m]."""
    approach: float = 0.0
    """Angle of the approach to the surface's normal [deg]."""
    place: int = 0


def motions() -> dict[str, ToolMotion]:
    """All motions by name."""
    slides = {name: ToolMotion(name, RADIUS - PATHS[name][0]) for name in ("shallow", "deep")}
    deeper = {f"penetration {1e3 * depth:g} mm": ToolMotion("penetration", depth) for depth in PENETRATIONS}
    straight = [ToolMotion("approach", PRESSED, degrees, k) for degrees in APPROACHES for k in range(PLACES)]
    return slides | deeper | {f"approach {m.approach:g} deg, place {m.place}": m for m in straight}


def experiment(point: Point, seed: int) -> Measured:
    """Measure one method along one path over one mesh; the experiment is deterministic."""
    motion = motions()[point["way"]]
    mesh, (judging, path) = _mesh(point["shape"], point["size"]), _path(point["shape"], motion)
    return {
        "triangles": mesh.triangle_count,
        "path": motion.path,
        "penetration_mm": motion.penetration * 1e3,
        "approach_deg": motion.approach,
        **judge(mesh, judging, path, point["method"]),
    }


@lru_cache(2)
def _mesh(shape: str, triangles: int) -> _core.Mesh:
    with warnings.catch_warnings():  # the open meshes of wavy sheet and groove are intended
        warnings.simplefilter("ignore", PalpateWarning)
        return Mesh(*SHAPES[shape].mesh(triangles), name=shape).core


@lru_cache(2)
def _path(name: str, motion: ToolMotion) -> tuple[Shape, ToolPath]:
    """The reference shape and the sampled tool path."""
    shape = SHAPES[name]
    if motion.path == "approach":
        return shape, next(islice(approaches(shape, motion.approach), motion.place, None))
    if motion.path == "penetration":
        pressed = PRESSED_FROM_ABOVE.get(name, shape)
        return pressed, _first_seconds(tool_path(pressed, RADIUS - motion.penetration, SPEED, RADIUS), 4.0)
    return shape, tool_path(shape, *PATHS[motion.path], RADIUS)


def _first_seconds(path: ToolPath, seconds: float) -> ToolPath:
    """The path up to the first ``seconds`` [s] of its slide."""
    end = path.steady.start + round(seconds * RATE)
    return ToolPath(path.tips[:end], slice(path.steady.start, end))


def approaches(shape: Shape, degrees: float) -> Iterator[ToolPath]:
    """Straight approaches at an angle to the normal with a rest at r - phi = ``PRESSED``, at several places."""
    for i in range(PLACES):
        end = shape.curve(np.array([0.13 + i / PLACES]), RADIUS - PRESSED)
        normal = shape.distance(end)[1][0]
        side = np.cross(normal, [np.cos(i), np.sin(i), 0.3])
        side /= np.linalg.norm(side)
        a = np.radians(degrees)
        back = np.cos(a) * normal + np.sin(a) * side
        length = (PRESSED + 2e-3) / np.cos(a)  # starts 2 mm outside
        samples = round(length / SPEED * RATE) + 2
        inward = end + back * np.linspace(length, 0.0, samples)[:, None]
        rest = np.tile(end, (60, 1))
        out = end + back * np.linspace(0.0, length, samples)[:, None]
        yield ToolPath(np.vstack([inward, rest, out]), slice(samples + 10, samples + 60))


def grown_planes(seed: int = 0) -> Iterator[GrownPlanes]:
    """Normal errors of planes through noisy points of the 30 mm sphere, by number and spread of the points."""
    rng, shape = np.random.default_rng(seed), SHAPES["sphere"]
    up = np.array([0.0, 0.0, 1.0])
    for noise in NOISES:
        for spread in SPREADS:
            for n in POINTS:
                error, refused = [], 0
                for _ in range(DRAWS):
                    angle, reach = rng.uniform(0, 2 * np.pi, n), spread / 2 * np.sqrt(rng.uniform(0, 1, n))
                    points = np.column_stack([reach * np.cos(angle), reach * np.sin(angle), np.full(n, 0.03)])
                    points -= shape.distance(points)[0][:, None] * shape.distance(points)[1]
                    normal = _collision.grow_plane(points + rng.normal(0, noise, (n, 3)), up, 0.05 * RADIUS)
                    refused += not normal.any()
                    if normal.any():
                        error.append(np.degrees(np.arctan2(np.linalg.norm(np.cross(normal, up)), normal @ up)))
                median, p95 = np.percentile(error, [50, 95]) if error else (None, None)
                yield {
                    "points": n,
                    "spread_mm": spread * 1e3,
                    "noise_um": noise * 1e6,
                    "refused": refused / DRAWS,
                    "direction_median_deg": median,
                    "direction_p95_deg": p95,
                }
