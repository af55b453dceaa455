"""A scene with soft tissue in lockstep: energies, ledger, status, and the same bytes every time."""

from __future__ import annotations

import numpy as np
import pytest
from soft_bodies import lockstep, soft_cube

import palpate

SCENE = """
objects:
  - name: cube
    box: {size: [0.06, 0.06, 0.04]}
    unit: m
    friction: 0.2
    tissue: {volume: cube.vtk, preset: liver, fixed: [{at: [0, 0, -0.02], box: [0.2, 0.2, 0.002]}]}
contact: {radius: 0.006}
operator: {palpate: {approach: 0.3, press: 1.0, force: 0.25}}
"""


@pytest.fixture
def run(tmp_path):
    """Ticks of 1.6 s of a palpation of a soft cube."""
    scene = soft_cube(tmp_path, SCENE)
    return lambda: lockstep(palpate.Session(scene), 1600)


def test_press_stores_energy_in_the_tissue_that_the_hand_put_in(run):
    ticks = run()
    force = np.linalg.norm(ticks["F_T_W"], axis=1)
    assert 0.15 < force.max() < 0.4
    assert ticks["tissue_potential"].max() > 2e-5
    assert ticks["tissue_kinetic"].max() > 0
    assert (ticks["tissue_status"] == 0).all()
    assert (ticks["energy_spring"] >= ticks["tissue_potential"] * 0.99).all(), "the ledger counts the tissue"
    assert ticks["energy_port"].min() > -0.5e-3
    spent = ticks["energy_port"] + ticks["energy_cut"] + ticks["energy_passivity"]
    assert (spent - ticks["energy_spring"] - ticks["energy_mapping"])[-1] > -1e-4, "more comes in than is stored"


def test_lockstep_repeats_its_bytes(run):
    first, second = run(), run()
    names = [n for n in first.dtype.names if n not in ("cycle_us", "lateness_us")]
    assert all(first[n].tobytes() == second[n].tobytes() for n in names)
