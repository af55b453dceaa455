"""The near field of a contact: what it knows of the material below, and the energy that belongs to its force."""

from __future__ import annotations

import numpy as np
import pytest

from palpate import Tissue
from palpate.world.tissue.blocks import block
from palpate_lab.verify.bench.tissue import Lab, lump
from palpate_lab.verify.tissue import reference_force

R, UP = 5e-3, np.array([0.0, 0.0, 1.0])


def half(stiff, **material):
    """The surface of a slab with its top at z = 0; stiff: function of the tetrahedra's centres (m, 3) -> (m,) bool."""
    nodes, tets = block((6, 6, 6), (0.06, 0.06, 0.03))
    nodes = nodes - [0.03, 0.03, 0.03]
    young = np.where(stiff(nodes[tets].mean(axis=1)), 50e3, 5e3)
    return Tissue((nodes, tets), young=young, poisson=0.45, fixed=nodes[:, 2] < -0.0299, **material).core.own()


def nothing(x):
    return x[:, 2] > 1.0


def below(depth):
    return lambda x: x[:, 2] < -depth


def half_of(cells):
    """Of the tetrahedra of the slab, those at x < 0."""
    nodes, tets = block((cells, cells, cells), (0.06, 0.06, 0.03))
    return nodes[tets].mean(axis=1)[:, 0] < 0.03


def force_at(surface, depth, x=0.0):
    return surface.near_field(np.array([x, 0.0, 0.0]), UP, depth, R)[0]


@pytest.mark.parametrize(
    "surface", [half(nothing), half(below(0.01)), half(nothing, yeoh=2.0)], ids=["even", "layers", "yeoh"]
)
def test_force_is_the_slope_of_the_energy_and_the_tangent_that_of_the_force(surface):
    depth = np.linspace(1e-4, 8e-3, 4001)
    force, tangent, stored = np.array([surface.near_field(np.zeros(3), UP, d, R) for d in depth]).T
    np.testing.assert_allclose(np.gradient(stored, depth)[2:-2], force[2:-2], rtol=1e-3, atol=1e-6)
    np.testing.assert_allclose(np.gradient(force, depth)[2:-2], tangent[2:-2], rtol=0.01, atol=0.01)
    assert (np.diff(tangent) > -1e-9).all()


def test_stiff_ground_is_felt_the_more_the_nearer_it_lies():
    even, *layers = (force_at(half(stiff), 1e-3) for stiff in (nothing, below(0.02), below(0.01), below(0.005)))
    assert layers[0] / even == pytest.approx(1.0, abs=0.05), "the body itself knows what lies deep"
    assert even < layers[1] < layers[2] < 10.0 * even
    assert force_at(half(below(-1.0)), 1e-3) == pytest.approx(10.0 * even, rel=1e-9), "all of it is stiff"


def test_stiffening_is_felt_in_proportion_to_depth_and_only_where_it_is():
    depth = 0.05 * R
    even, all_of_it, left = (
        np.array([force_at(half(nothing, yeoh=c), depth, x) for x in (-0.015, 0.015)])
        for c in (0.0, 1.0, np.where(half_of(6), 1.0, 0.0))
    )
    np.testing.assert_allclose(all_of_it / even, 1.0 + 0.18 * 0.05, rtol=5e-3)
    assert left == pytest.approx([all_of_it[0], even[1]], rel=1e-9)
    assert all_of_it[0] > 1.005 * even[0]


def test_force_does_not_jump_at_the_border_of_a_part():
    surface = half(lambda x: x[:, 0] > 0.0)
    force = np.array([force_at(surface, 1e-3, x) for x in np.linspace(-0.012, 0.012, 481)])
    assert np.abs(np.diff(force)).max() < 0.02 * np.ptp(force)
    assert force[-1] > 8.0 * force[0], "control: there is a border"


@pytest.mark.parametrize("cell", [7.5e-3, 5e-3])
def test_lump_below_the_surface_is_felt_as_by_finite_elements(cell):
    soft = lump.with_lump(Lab(), cell, lump.TOPS[0])
    depth = 0.25 * lump.RADIUS
    found = Lab().steady(soft, lump.RADIUS, depth)
    case = (lump.RADIUS, depth, 5e3, 0.45)
    truth = float(reference_force(*case, h=lump.THICKNESS, lump=(lump.TOPS[0], lump.BALL, lump.RATIO)))
    assert found == pytest.approx(truth, rel=0.1)
    bare = float(reference_force(*case, h=lump.THICKNESS))
    assert bare < 0.8 * truth, "control: the lump matters"
