"""Valleys and hills of coarse meshes, narrower than the sphere: the proxy jumps there, and no jump may give energy."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.scene.contact import render
from palpate.world.shapes import analytic

K = 400.0


def hills(amplitude, wavelength):
    """A closed block with a hilly upper side, in cells of 0.7 mm."""
    x = np.linspace(-0.018, 0.018, 53)
    X, Y = np.meshgrid(x, x, indexing="ij")
    k = 2 * np.pi / wavelength
    top = np.stack([X, Y, amplitude * np.sin(k * X) * np.cos(k * Y)], axis=-1).reshape(-1, 3)
    bottom = top * [1, 1, 0] - [0, 0, 0.012]
    n, i = len(x), np.arange(len(x) - 1)
    a = (i[:, None] * n + i).ravel()
    sheet = np.concatenate([np.stack([a, a + n, a + n + 1], 1), np.stack([a, a + n + 1, a + 1], 1)])
    rim = np.concatenate([i * n, (n - 1) * n + i, (n - 1 - i) * n + n - 1, n - 1 - i])
    after = np.roll(rim, -1)
    side = np.concatenate([np.stack([after, rim, after + n * n], 1), np.stack([after + n * n, rim, rim + n * n], 1)])
    return np.concatenate([top, bottom]), np.concatenate([sheet, sheet[:, ::-1] + n * n, side]).astype(np.int32)


def work_of(force, tips):
    return -(0.5 * (force[1:] + force[:-1]) * np.diff(tips, axis=0)).sum()


@pytest.mark.parametrize("shape", [(0.0036, 0.0118), (0.002, 0.008), (0.003, 0.0127), (0.0014, 0.007)])
@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_loops_in_valleys_narrower_than_the_sphere_hand_out_no_energy(shape, seed):
    rng = np.random.default_rng(seed)
    radius = rng.uniform(0.002, 0.006)
    inner = np.column_stack([rng.uniform(-0.008, 0.008, (4, 2)), rng.uniform(-0.2, 0.7, 4) * radius])
    ends = np.column_stack([inner[[0, -1], :2], np.full(2, shape[0] + 1.2 * radius)])
    knots = np.concatenate([ends[:1], inner, ends[1:], ends[:1]])
    tips = np.concatenate(
        [np.linspace(a, b, int(np.linalg.norm(b - a) / 1e-5) + 2, endpoint=False) for a, b in pairwise(knots)]
    )
    for way in (tips, tips[::-1]):
        force = render(hills(*shape), way, radius=radius, stiffness=K).force
        stored = 0.5 * (force**2).sum(axis=1).max() / K
        assert work_of(force, way) > -2e-3 * stored


def test_smooth_meshes_keep_their_force():
    """On a ball of facets the force is still that of the smooth distance, at every tick of a slide."""
    mesh = _core.Mesh(*analytic.Sphere(0.03).mesh(5000))
    angle = np.linspace(-0.4, 0.4, 4000)
    tips = (0.03 + 0.002 - 0.0015) * np.stack([np.sin(angle), 0.2 * np.sin(9 * angle), np.cos(angle)], axis=1)
    tips *= (0.0305 / np.linalg.norm(tips, axis=1))[:, None]
    down = np.linspace(1.1 * tips[0], tips[0], 200)
    rendered = render(mesh, np.concatenate([down, tips]), radius=0.002, stiffness=K)
    out = tips / np.linalg.norm(tips, axis=1)[:, None]
    np.testing.assert_allclose(rendered.force[200:], K * 0.0015 * out, atol=0.01 * K * 0.0015)
