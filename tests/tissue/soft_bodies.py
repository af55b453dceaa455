"""Soft bodies for tests: boxes of tetrahedra with one material, alone or in a scene."""

from __future__ import annotations

import numpy as np
import pytest

import palpate
from palpate import _tissue
from palpate.record.ticks import Ticks, as_ticks
from palpate.world.tissue import TetMesh, save
from palpate.world.tissue.blocks import block

CUBE = """
objects:
  - name: soft cube
    box: {size: [0.06, 0.06, 0.04]}
    unit: m
    tissue: {volume: cube.vtk, preset: liver, fixed: [{at: [0, 0, -0.02], box: [0.2, 0.2, 0.002]}]}
contact: {radius: 0.006}
"""
"""A soft liver cube for `soft_cube`, to which a test adds operators or pairs."""


def box(cells, size):
    """Nodes (n, 3), tetrahedra (m, 4) and boundary triangles (k, 3) of a box."""
    mesh = TetMesh(*block(cells, size))
    return mesh.nodes, mesh.tets, mesh.surface


def soft_cube(folder, text):
    """The scene of a text that names the file cube.vtk: a block of 60 x 60 x 40 mm around the origin."""
    pytest.importorskip("meshio", reason="extra tissue")
    nodes, tets = block((5, 5, 4), (0.06, 0.06, 0.04))
    save(TetMesh(nodes - [0.03, 0.03, 0.02], tets), folder / "cube.vtk", unit="m")
    (folder / "soft.yaml").write_text(text)
    return palpate.Scene.load(folder / "soft.yaml")


def lockstep(session: palpate.Session, n: int) -> Ticks:
    """The next `n` ticks of a session."""
    return as_ticks(np.concatenate(session._advance(n)))


def body(
    mesh, young=5000.0, poisson=0.45, density=1000.0, *, fixed=None, yeoh=0.0, prony=(), spring=None, mu=None, **options
):
    """A ``TissueBody`` of one material; ``mu`` (m,) replaces the shear modulus."""
    nodes, tets, surface = mesh
    m = len(tets)
    shear = np.full(m, young / (2.0 * (1.0 + poisson))) if mu is None else mu
    return _tissue.TissueBody(
        nodes=np.ascontiguousarray(nodes),
        tets=tets,
        surface=surface,
        mu=shear,
        bulk=np.full(m, young / (3.0 * (1.0 - 2.0 * poisson))),
        density=np.full(m, density),
        yeoh=np.full(m, float(yeoh)),
        prony=list(prony),
        fixed=np.zeros(len(nodes), bool) if fixed is None else fixed,
        spring=np.zeros(len(nodes)) if spring is None else spring,
        **options,
    )


def settle(soft, seconds, brake=200):
    """Relax the body by dynamic relaxation: velocities are zeroed every ``brake`` steps."""
    n = len(soft.positions())
    for _ in range(int(seconds / soft.time_step / brake)):
        soft.step(brake)
        soft.set_state(soft.positions(), np.zeros((n, 3)))
