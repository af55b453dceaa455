"""Friction on curved surfaces, edges and corners, judged by its work alone: own quadrature."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import PointCloud, _core
from palpate.scene.contact import render
from palpate.world import surfaces
from palpate.world.mesh import Mesh
from palpate.world.shapes import analytic

RADIUS, K, MU = 2e-3, 800.0, 0.6


def bowl():
    """The lower half of a sphere as an open mesh, touched from inside."""
    vertices, triangles = analytic.Sphere(0.009).mesh(2000)
    return Mesh(vertices, triangles[vertices[triangles][:, :, 2].max(axis=1) < 0.001], name="bowl")


def ball_cloud():
    p = np.random.default_rng(0).normal(size=(4000, 3))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    return surfaces.PointSurface(PointCloud(0.01 * p, normals=p))


#: A surface and a point near it, where the tool touches.
PLACES = {
    "sphere": (lambda: surfaces.Sphere(0.005), [0.001, 0.0, 0.006]),
    "cylinder": (lambda: surfaces.Cylinder(0.004, 0.03), [0.005, 0.0, 0.003]),
    "rim of a cylinder": (lambda: surfaces.Cylinder(0.004, 0.02), [0.0047, 0.0, 0.0107]),
    "capsule": (lambda: surfaces.Capsule(0.003, 0.02), [0.0, 0.002, 0.0125]),
    "edge of a box": (lambda: surfaces.Box([0.02, 0.02, 0.02]), [0.0107, 0.0106, 0.001]),
    "corner of a box": (lambda: surfaces.Box([0.02, 0.02, 0.02]), [0.0107, 0.0106, 0.0107]),
    "implicit": (lambda: surfaces.ImplicitSurface.of_half_lengths([0.006, 0.004, 0.005]), [0.0, 0.0005, 0.006]),
    "mesh": (lambda: Mesh(*analytic.Sphere(0.006).mesh(1200), name="ball"), [0.001, 0.0005, 0.007]),
    "bowl": (bowl, [0.001, 0.0005, -0.007]),
    "inside of a torus": (lambda: Mesh(*analytic.Torus(0.02, 0.006).mesh(8000), name="torus"), [0.013, 0.001, 0.001]),
    "edge of a mesh": (lambda: Mesh(*analytic.Box((0.02,) * 3).mesh(1200), name="box"), [0.0107, 0.0106, 0.001]),
    "cloud": (ball_cloud, [0.001, 0.0, 0.011]),
}


@pytest.fixture(scope="module", params=PLACES)
def place(request):
    make, at = PLACES[request.param]
    return make(), np.array(at)


def sphere_path(surface, feet, depths, per):
    """Centres at depths (n,) [m] under points near the surface (n, 3), straight between them."""
    _, q, n = surface.core.nearest(np.ascontiguousarray(feet))
    knots = q + (RADIUS - np.asarray(depths))[:, None] * n
    return np.concatenate([*(np.linspace(a, b, per, endpoint=False) for a, b in pairwise(knots)), knots[-1:]])


def by_friction(surface, tips, mu=MU, mu_static=0.0, stiffness=K):
    """Force with friction, the part that friction adds [N], and the work that the hand puts into it [J]."""
    with_it = render(surface, tips, radius=RADIUS, stiffness=stiffness, friction=mu, static_friction=mu_static)
    force = with_it.force - render(surface, tips, radius=RADIUS, stiffness=stiffness).force
    return with_it, force, np.cumsum(-(0.5 * (force[1:] + force[:-1]) * np.diff(tips, axis=0)).sum(axis=1))


def test_stick_loop_returns_its_energy_at_every_depth(place):
    """Deep out and shallow back, both ways, 10 times; the tool never slips."""
    surface, at = place
    aside = 0.25 * MU * 0.0005 * np.cross([0.3, -0.5, 0.8], at / np.linalg.norm(at))
    loop = [(at, 0.0005), (at, 0.0013), (at + aside, 0.0013), (at + aside, 0.0005)]
    for steps in (loop, loop[::-1]):
        feet, depths = zip(*([(at, -0.0005), (at, 0.0005)] + 10 * steps + [steps[0]]), strict=True)
        tips = sphere_path(surface, feet, depths, 200)
        _, _, work = by_friction(surface, tips)
        assert abs(work[-1] - work[-1 - 200 * 40]) < 1e-9 * 0.5 * K * 0.0013**2 * MU**2
        assert work.max() > 1e-3 * K * 0.0005**2 * MU**2  # friction has stored energy meanwhile


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_friction_never_pays_back_more_than_it_took(place, seed):
    """Random paths of stick and slip, 1 % to 95 % of the radius deep: at no moment has the hand gained."""
    surface, at = place
    rng = np.random.default_rng(seed)
    mu, stiffness = np.exp(rng.uniform(np.log([0.05, 50]), np.log([1.5, 5000])))
    spread = np.exp(rng.uniform(np.log(1e-4), np.log(2e-3)))
    feet = at + spread * rng.normal(size=(9, 3))
    depths = np.concatenate([[-0.0004], RADIUS * rng.uniform(0.01, 0.95, 7), [-0.0004]])
    tips = sphere_path(surface, feet, depths, 400)
    rendered, _, work = by_friction(surface, tips, mu, mu * rng.uniform(1.0, 1.7), stiffness)
    scale = 0.5 * stiffness * RADIUS**2
    assert work.min() > -1e-5 * scale
    assert np.isfinite(rendered.force).all()


def test_the_cone_holds_with_the_surface_normal(place):
    surface, at = place
    rng = np.random.default_rng(4)
    feet = at + 1e-3 * rng.normal(size=(12, 3))
    tips = sphere_path(surface, feet, RADIUS * rng.uniform(0.05, 0.95, 12), 300)
    rendered, _, _ = by_friction(surface, tips, 0.3, 0.5)
    normal = (rendered.normal * rendered.force).sum(axis=1)
    tangential = np.linalg.norm(rendered.force - normal[:, None] * rendered.normal, axis=1)
    assert (tangential <= 0.5 * normal + 1e-9 * K * RADIUS).all()


def test_steady_slip_has_the_dynamic_coefficient_and_the_frictionless_load():
    """Around a sphere at a constant depth: the friction is mu of the load, and the load that without friction."""
    angle = np.linspace(0.0, 1.5, 4000)
    tips = (0.006 + RADIUS - 0.0015) * np.stack([np.sin(angle), 0 * angle, np.cos(angle)], axis=1)
    down = np.linspace([0, 0, 0.0085], tips[0], 200)
    rendered, force, _ = by_friction(surfaces.Sphere(0.006), np.concatenate([down, tips]), 0.3)
    normal, slipped = (rendered.normal * rendered.force).sum(axis=1)[1500:], force[1500:]
    along = np.linalg.norm(
        slipped - (slipped * rendered.normal[1500:]).sum(1)[:, None] * rendered.normal[1500:], axis=1
    )
    np.testing.assert_allclose(along / normal, 0.3, rtol=5e-3)
    np.testing.assert_allclose(normal, K * 0.0015, rtol=5e-3)


def drive(rng, steps):
    """Random smooth sequences of normal, depth, stiffness and position, which no surface needs to explain."""
    t = np.linspace(0.0, 1.0, steps)[:, None]
    wave = [
        sum(a * np.sin(2 * np.pi * (k * t + b)) for k, (a, b) in enumerate(rng.uniform(0, 1, (5, 2, 6)))) for _ in "xy"
    ]
    x, n = 1e-3 * wave[0][:, :3], wave[0][:, 3:] + [0.0, 0.0, 3.0]
    return x, n / np.linalg.norm(n, axis=1)[:, None], 1e-3 * (1.3 + wave[1][:, 0] / 4), 500 * np.exp(wave[1][:, 1])


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_law_is_passive_while_everything_changes(seed):
    """Normal, depth and stiffness change at will, as on tissue and over lumps: work minus stored energy never falls."""
    rng = np.random.default_rng(seed)
    x, n, depth, k = drive(rng, 3000)
    mu = rng.uniform(0.05, 1.5)
    friction = _core.Friction()
    force, stored = [], []
    for i in range(len(x)):
        lag = friction.step(x[i], n[i], abs(depth[i]) + 1e-5, mu, 1.4 * mu, k[i], 1e-3)
        force.append(k[i] * lag)
        stored.append(0.5 * k[i] * lag @ lag)
    force = np.array(force)
    work = np.cumsum(-(0.5 * (force[1:] + force[:-1]) * np.diff(x, axis=0)).sum(axis=1))
    lost = work - np.array(stored)[1:]
    assert (np.maximum.accumulate(lost) - lost).max() < 1e-3 * max(np.ptp(work), max(stored))


def test_change_of_stiffness_keeps_the_stored_energy():
    friction = _core.Friction()
    friction.step(np.zeros(3), np.array([0, 0, 1.0]), 1e-3, 0.5, 0.5, 1000.0, 1e-3)
    before = friction.step(np.array([2e-4, 0, 0]), np.array([0, 0, 1.0]), 1e-3, 0.5, 0.5, 1000.0, 1e-3)
    after = friction.step(np.array([2e-4, 0, 0]), np.array([0, 0, 1.0]), 1e-3, 0.5, 0.5, 1700.0, 1e-3)
    assert 1700.0 * after @ after == pytest.approx(1000.0 * before @ before, rel=1e-12)
