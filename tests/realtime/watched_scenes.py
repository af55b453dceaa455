"""The scenes of watched.py, with their tops at the origin, and the hand that presses them."""

from functools import cache

import numpy as np

from palpate import _core, _tissue
from palpate.world.mesh import Mesh
from palpate.world.shapes.organs import organ
from palpate.world.tissue import Tissue
from palpate.world.tissue.blocks import block


@cache
def organ_scene(triangles: int, lift: float = 0.0, live: bool = False) -> _core.Snapshot:
    """The generated organ with motion and a nodule; its highest point is `lift` [m] above the origin.

    live: its pose is set while the loop runs, instead of the motion.
    """
    mesh = Mesh(*organ(triangles))
    X_WO = np.eye(4)
    X_WO[:3, 3] = -mesh.vertices[mesh.vertices[:, 2].argmax()] + [0.0, 0.0, lift]
    material = _core.Material(K=np.full(3, 400.0), B=np.full(3, 2.0), mu=0.3, mu_static=0.5)
    top = mesh.vertices[mesh.vertices[:, 2].argmax()].copy()
    lump = _core.Region(top, radius=0.004, blend=0.002, material=_core.Material(K=np.full(3, 600.0)))
    breath = _core.Wave(shift=np.array([0.0, 0.0, 0.001]), turn=np.array([0.01, 0.0, 0.0]), period=4.0)
    motion = _core.Motion(waves=[] if live else [breath])
    options = _core.LiveOptions(max_age=0.05, fade=0.1) if live else None
    return _core.Snapshot([_core.Object("organ", mesh.core, X_WO, material, [lump], motion, live=options)])


def targets(t: float) -> _core.LiveTargets:
    """A target near the place of the live organ, with a velocity, and a tracked frame."""
    found, X = _core.LiveTargets(), organ_scene(20_000).objects[0].X_WO.copy()
    X[2, 3] += 0.001 * np.sin(t)
    found.add(t, X, np.array([0.0, 0.0, 1e-3, 0.01, 0.0, 0.0]))
    found.add_frame(X, t, False)
    return found


def solids_scene() -> _core.Snapshot:
    """A scene without meshes: a box and a sampled ball, whose tops are at the origin."""
    x = np.linspace(-0.025, 0.025, 26)
    at = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1)
    ball = _core.DistanceGrid(
        np.full(3, x[0]), np.full(3, x[1] - x[0]), (np.linalg.norm(at, axis=-1) - 0.02).astype(np.float32)
    )
    material = _core.Material(K=np.full(3, 400.0), B=np.full(3, 2.0), mu=0.3)
    solids = (("box", _core.Box(np.full(3, 0.04))), ("ball", ball))
    X_WO = np.eye(4)
    X_WO[2, 3] = -0.02
    return _core.Snapshot([_core.Object(name, surface, X_WO, material) for name, surface in solids])


def cloud_scene() -> _core.Snapshot:
    """The organ as a point cloud with noise, whose surface is live as that of a camera."""
    mesh = Mesh(*organ(20_000))
    top = mesh.vertices[mesh.vertices[:, 2].argmax()]
    points = mesh.vertices - top + 5e-4 * np.random.default_rng(0).normal(size=mesh.vertices.shape)
    surface = _tissue.PointSurface(points, None, np.array([0.0, 0.0, 0.5]), 1.5e-3, 7e-3, 3e-3)
    material = _core.Material(K=np.full(3, 400.0), B=np.full(3, 2.0), mu=0.3)
    return _core.Snapshot([_core.Object("cloud", surface, np.eye(4), material, live=_core.LiveOptions(gain=60.0))])


def soft_scene(thread: str = "cycle") -> _core.Snapshot:
    """A soft block whose top is at the origin, stepped in the cycle or on a thread of its own."""
    nodes, tets = block((5, 5, 3), (0.05, 0.05, 0.03))
    nodes = nodes - [0.025, 0.025, 0.03]
    soft = Tissue((nodes, tets), young=8e3, prony=[(0.3, 0.05)], fixed=nodes[:, 2] < -0.0299, thread=thread)
    material = _core.Material(K=np.zeros(3), mu=0.3)
    return _core.Snapshot([_core.Object("soft", soft.core, np.eye(4), material)])


def press() -> _core.HandPath:
    """A hand path that is soon in contact, slides to and fro, and leaves repeatedly."""
    x = np.tile([0.0, 0.0, 0.008, -0.008, 0.0], 40)
    z = np.tile([0.004, -0.004, -0.004, -0.004, -0.004], 40)
    return _core.HandPath((0.1 + 0.2 * np.arange(len(x))).tolist(), np.column_stack([x, np.zeros_like(x), z]))
