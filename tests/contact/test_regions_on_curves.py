"""Regions on curved surfaces: the force is the gradient of the spring's energy, by finite differences and by loops."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.world import surfaces
from palpate.world.mesh import Mesh
from palpate.world.shapes import analytic

RADIUS = 2e-3


def material(K):
    return _core.Material(np.full(3, float(K)), np.zeros(3), 0.0)


def rendered(surface, region, tips, K=900.0):
    options = _core.ContactOptions()
    options.radius = RADIUS
    scene = _core.Snapshot([_core.Object("organ", surface.core, np.eye(4), material(K), [region])])
    return _core.contact_render(scene, np.ascontiguousarray(tips), "proxy", options, 1000.0)[0]


def lump(at, K):
    return _core.Region(np.asarray(at, float), radius=0.002, blend=0.004, material=material(K))


def sphere(x):
    return np.linalg.norm(x) - 0.006, x / np.linalg.norm(x)


def cylinder(x):
    ring = np.linalg.norm(x[:2])
    return ring - 0.005, np.array([*x[:2] / ring, 0.0])


def edge(x):
    """The edge of the box at x = y = 0.01, for points beyond both faces."""
    out = np.array([x[0] - 0.01, x[1] - 0.01, 0.0])
    return np.linalg.norm(out), out / np.linalg.norm(out)


def potential(shape, obj, x):
    """1/2 K d^2 with K at the deepest point of the sphere, from the distance alone."""
    distance, n = shape(x)
    return 0.5 * obj.feel(x - RADIUS * n)[0].K[0] * (RADIUS - distance) ** 2


CLOSED_FORMS = {
    "sphere": (sphere, surfaces.Sphere(0.006), [0.0015, 0.0005, 0.0065], [0.0, 0.0, 0.005]),
    "cylinder": (cylinder, surfaces.Cylinder(0.005, 0.05), [0.0055, 0.001, 0.0015], [0.004, 0.0, 0.0]),
    "edge": (edge, surfaces.Box([0.02, 0.02, 0.06]), [0.0105, 0.0108, 0.001], [0.0085, 0.009, 0.0]),
}


@pytest.mark.parametrize("shape", CLOSED_FORMS)
@pytest.mark.parametrize("K", [300.0, 2500.0])
def test_force_is_the_gradient_of_the_energy(shape, K):
    distance, surface, tool, at = CLOSED_FORMS[shape]
    obj = _core.Object("organ", surface.core, np.eye(4), material(900), [lump(at, K)])
    h = 1e-7
    for x in np.array(tool) + 3e-4 * np.random.default_rng(0).uniform(-1, 1, (20, 3)):
        force = rendered(surface, lump(at, K), np.linspace(2.0 * x, x, 50))[-1]
        slope = [(potential(distance, obj, x + e) - potential(distance, obj, x - e)) / (2 * h) for e in h * np.eye(3)]
        np.testing.assert_allclose(force, -np.array(slope), atol=2e-6 * np.linalg.norm(force))


LOOPS = {
    "sphere": (surfaces.Sphere(0.005), [0.0, 0.002, 0.006]),
    "capsule": (surfaces.Capsule(0.004, 0.02), [0.0, 0.004, 0.011]),
    "rim of a cylinder": (surfaces.Cylinder(0.006, 0.02), [0.0067, 0.0, 0.0107]),
    "mesh": (Mesh(*analytic.Sphere(0.008).mesh(5000), name="ball"), [0.001, 0.0005, 0.009]),
    "inside of a torus": (Mesh(*analytic.Torus(0.02, 0.006).mesh(8000), name="torus"), [0.013, 0.001, 0.001]),
}


@pytest.mark.parametrize("place", LOOPS)
@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_pressing_in_beside_a_lump_and_coming_out_over_it_gains_nothing(place, seed):
    surface, at = LOOPS[place]
    rng = np.random.default_rng(seed)
    feet = at + 1.2e-3 * rng.normal(size=(6, 3))
    feet[[1, -1]] = feet[0], feet[-2]
    depths = np.array([-5e-4, *rng.uniform(2e-4, 1.3e-3, 4), -5e-4])
    feet, depths = np.vstack([feet, feet[:1]]), np.append(depths, -5e-4)
    f, d = (
        np.concatenate([*(np.linspace(a, b, 1500, endpoint=False) for a, b in pairwise(knots)), knots[-1:]])
        for knots in (feet, depths)
    )
    _, q, n = surface.core.nearest(np.ascontiguousarray(f))
    tips = q + (RADIUS - d)[:, None] * n
    _, q, _ = surface.core.nearest(np.array([at]))
    force = rendered(surface, lump(q[0], rng.choice([2500.0, 4000.0])), tips)
    work = -(0.5 * (force[1:] + force[:-1]) * np.diff(tips, axis=0)).sum()
    assert abs(work) < 2e-4 * 0.5 * 2500.0 * 1.3e-3**2
