"""Two spheres hold a fin of tissue between them and pull: friction lifts it, until it slips."""

from __future__ import annotations

import numpy as np
import pytest

from palpate import Tissue
from palpate.scene.contact import render
from palpate.world.tissue.blocks import block

R, GAP = 4e-3, 8.5e-3  # radius of the spheres; half the distance of their centres [m]


def pulled(friction):
    """Force (n, 3) on both spheres: they slide over the fin, squeeze it by 1.5 mm each side, and pull it up."""
    nodes, tets = block((10, 3, 8), (0.05, 0.012, 0.04))
    nodes = nodes - [0.025, 0.006, 0.04]
    fin = Tissue((nodes, tets), young=8e3, fixed=nodes[:, 2] < -0.0399, damping=20.0)
    s = np.linspace(0.0, 1.0, 300)
    x = np.concatenate([0.04 - 0.04 * s * s * (3.0 - 2.0 * s), np.zeros(900)])
    z = np.concatenate([np.full(500, -0.008), -0.008 + 0.02 * np.linspace(0.0, 1.0, 600), np.full(100, 0.012)])
    tips = np.stack([x, np.full_like(x, -GAP), z], axis=1)
    return render(fin, tips, radius=R, friction=friction, spheres=[([0.0, 2.0 * GAP, 0.0], R)]).force


@pytest.fixture(scope="module")
def forces():
    """Forces by the coefficient of friction."""
    return {mu: pulled(mu) for mu in (0.0, 0.2, 0.8)}


def test_grasp_lifts_by_friction_alone(forces):
    lifting = slice(640, 740)
    up = {mu: -f[lifting, 2].mean() for mu, f in forces.items()}
    below_the_edge = slice(540, 620)  # nearer to it than a radius, the squeezed top also pushes the spheres up
    assert abs(forces[0.0][below_the_edge, 2].mean()) < 0.002, "control: without friction it slips out"
    assert up[0.8] > 0.05
    assert up[0.8] == pytest.approx(4.0 * up[0.2], rel=0.3), "it slips at mu times the squeeze"
    assert np.abs(forces[0.8][:, 1]).max() < 0.1 * up[0.8], "both sides squeeze alike"


def test_tissue_that_slipped_out_is_free(forces):
    for force in forces.values():
        assert np.isfinite(force).all()
        assert (force[-100:] == 0.0).all()
