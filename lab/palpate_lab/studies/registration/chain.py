"""The whole chain of the paper's Fig 2, simulated: tracker, world, two PSMs and a camera that sees the organ.

A tracker K sees four markers of four spheres each: on a phantom (W), on the bases of two PSMs, and on a camera. Both
PSMs touch divots of the phantom and the camera sees them, which places the arms' bases and the camera relative to their
markers. Then all carts are moved, the tracker looks again, and a view of the organ is
registered with its model. The graph of frames gives the organ in each arm's base.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from palpate.base.arrays import Array
from palpate.base.arrays.rigid import exp, inverse, rigid, transform
from palpate.base.sweep.grid import Point
from palpate.scene.contact import render
from palpate.world.frames import FrameGraph
from palpate.world.frames.edge import Edge
from palpate.world.mesh import Mesh
from palpate.world.registration import points, surface
from palpate.world.shapes.organs import organ
from palpate_lab.studies.registration import surfaces

READINGS, DIVOTS, PLACES = 60, 12, 20  # averaged readings of tracker and camera; divots; touched places of a set-up
TIP, CAMERA = 0.3e-3, 1e-3  # rms error of a touching tip; standard deviation of a seen point on each axis [m]
RADIUS, STIFFNESS = 1e-3, 500.0  # of the touching sphere [m], of the organ [N/m]
_SPHERES = 1e-3 * np.array([[0.0, 0.0, 0.0], [80.0, 0.0, 0.0], [0.0, 60.0, 0.0], [-30.0, -50.0, 25.0]])
_ARMS = ("PSM1", "PSM2")
_CARTS = (*_ARMS, "camera")


def judged(point: Point, seed: int) -> dict[str, float]:
    """Errors at twenty places of one set-up: median and largest, of the tip and of the felt contact [m]."""
    rng = np.random.default_rng(seed)
    X_PB = {name: _placed(rng, 0.15) for name in _CARTS}  # base of the arm, or camera, in the frame of its marker
    calibrated = {name: _calibrated(rng, X_PB[name], CAMERA if name == "camera" else TIP) for name in _CARTS}
    X_KP = {name: _placed(rng, 0.4) for name in _CARTS}  # the carts now, after they were moved
    edges = [Edge("world", name, _seen(rng, X_KP[name])) for name in _CARTS]
    edges += [Edge(name, f"{name} base", calibrated[name]) for name in _CARTS]
    X_KO = _placed(rng, 0.1)
    X_KC = X_KP["camera"] @ X_PB["camera"]
    X_CO, view = _organ_in_camera(rng, inverse(X_KC) @ X_KO)
    edges.append(Edge("camera base", "organ", X_CO))
    graph = FrameGraph(edges)
    tip, felt = [], []
    for name in _ARMS:
        X_BO_true = inverse(X_KP[name] @ X_PB[name]) @ X_KO
        X_BO = graph.pose("organ", f"{name} base").X
        one, other = _touched(rng, inverse(X_BO_true) @ X_BO, view)
        tip.append(one)
        felt.append(other)
    tips, contacts = np.concatenate(tip), np.concatenate(felt)
    return {
        "tip_median_m": float(np.median(tips)), "tip_largest_m": float(tips.max()),
        "felt_median_m": float(np.median(contacts)), "felt_largest_m": float(contacts.max()),
        "felt_within": float((contacts <= 1e-3).mean()),
    }  # fmt: skip


def _placed(rng: np.random.Generator, reach: float) -> Array:
    """A pose with a moderate rotation, up to `reach` [m] along each axis."""
    return rigid(exp(rng.uniform(-0.6, 0.6, 3)), rng.uniform(-reach, reach, 3))


def _seen(rng: np.random.Generator, X_KP: Array) -> Array:
    """Pose of a marker, from the mean of the tracker's readings of its spheres."""
    sigma = 0.25e-3 / np.sqrt(3.0 * READINGS)
    read = transform(X_KP, _SPHERES)
    return points(_SPHERES, read + sigma * rng.normal(size=read.shape)).X


def _calibrated(rng: np.random.Generator, X_PB: Array, noise: float) -> Array:
    """X_PB from divots of the phantom, which carries the world's marker W: X_PK X_KW X_WB."""
    X_KW, X_KP = _placed(rng, 0.2), _placed(rng, 0.4)
    p_WD = rng.uniform(-0.1, 0.1, (DIVOTS, 3))
    p_BD = transform(inverse(X_KP @ X_PB) @ X_KW, p_WD)
    sigma = noise / np.sqrt(READINGS) if noise == CAMERA else noise / np.sqrt(3.0)
    X_WB = points(p_BD + sigma * rng.normal(size=p_BD.shape), p_WD).X
    return inverse(_seen(rng, X_KP)) @ _seen(rng, X_KW) @ X_WB


def _organ_in_camera(rng: np.random.Generator, X_CO: Array) -> tuple[Array, Array]:
    """X_CO from a view of 30 % of the organ, started up to 30 deg and 30 mm off, and the view in the organ's frame."""
    model, pool, _ = surfaces.models()
    view = surfaces.view(rng, pool)
    start = surfaces.rough(rng, view, inverse(X_CO), (-surfaces.ANGLE, surfaces.ANGLE), surfaces.REACH)
    return inverse(surface(transform(X_CO, view), model, start).X), view


@cache
def _body() -> tuple[Mesh, Array, Array]:
    """The organ with its vertices (N, 3) and their outward normals (N, 3)."""
    vertices, triangles = organ(20_000)
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(normals, triangles[:, k], faces)
    return Mesh(vertices, triangles), vertices, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _touched(rng: np.random.Generator, X_TO: Array, view: Array) -> tuple[Array, Array]:
    """Errors [m] of places that one arm touches, half of all: of a tip sent to a seen vertex, and of the felt contact.

    X_TO: the organ as the arm believes it, in the true organ; view: the seen points in the organ's frame. Both errors
    are distances to the true surface: of the tip's centre, and of the sphere's nearest point at the first force.
    """
    mesh, vertices, normals = _body()
    tip, felt = [], []
    seen = view[mesh.closest(view)[0] < 3.0 * surfaces.NOISE]  # without outliers
    for q in rng.choice(seen, PLACES // len(_ARMS), replace=False):
        k = np.argmin(np.linalg.norm(vertices - q, axis=1))
        p_O = vertices[k] + normals[k] * np.linspace(4e-3, -4e-3, 801)[:, None]  # approach by 0.01 mm a tick
        force = np.linalg.norm(render(mesh, p_O, radius=RADIUS, stiffness=STIFFNESS).force, axis=1)
        first = p_O[np.argmax(force > 1e-3)]
        p_T = transform(X_TO, np.stack([vertices[k], first]))
        _, nearest, outward, _ = mesh.closest(p_T)
        height = np.einsum("ij,ij->i", p_T - nearest, outward)  # signed distance from the true surface
        tip.append(abs(height[0]))
        felt.append(abs(height[1] - RADIUS))
    return np.array(tip), np.array(felt)
