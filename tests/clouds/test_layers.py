"""Two layers of points that become one surface are told; single layers of any noise and shape are not."""

import warnings

import numpy as np
import pytest

from palpate import PointCloud
from palpate.base.errors import PalpateWarning
from palpate.world.clouds.neighbourhoods import layer_gap, sampling
from palpate.world.surfaces import PointSurface
from palpate.world.surfaces.points import Scales


def sheet(rng, n=3000, side=0.05, noise=1e-4, z=0.0):
    return np.column_stack([rng.uniform(-side / 2, side / 2, (n, 2)), z + noise * rng.normal(size=n)])


def gap_of(points, normals=None):
    return layer_gap(points, Scales.of(sampling(points)).support, normals)


@pytest.mark.parametrize(("gap", "noise"), [(5e-4, 5e-5), (1e-3, 0.0), (1e-3, 1.5e-4), (2e-3, 3e-4)])
def test_two_sheets_are_found_and_measured(gap, noise):
    rng = np.random.default_rng(0)
    found = gap_of(np.concatenate([sheet(rng, noise=noise), sheet(rng, noise=noise, z=gap)]))
    assert found == pytest.approx(gap, rel=0.25)


def test_a_flap_over_a_small_part_is_found():
    rng = np.random.default_rng(1)
    assert gap_of(np.concatenate([sheet(rng, 5000), sheet(rng, 700, 0.02, z=0.0012)])) > 0.0009


def one_ball(rng, noise=1e-4):
    d = rng.normal(size=(5000, 3))
    return d / np.linalg.norm(d, axis=1)[:, None] * (0.008 + noise * rng.normal(size=(5000, 1)))


def box(rng):
    p = rng.uniform(-0.01, 0.01, (6000, 3))
    axis = rng.integers(0, 3, 6000)
    p[np.arange(6000), axis] = 0.01 * rng.choice([-1, 1], 6000)
    return p


def waves(rng):
    p = sheet(rng)
    return p + np.column_stack([0 * p[:, :2], 0.002 * np.sin(600 * p[:, 0])])


def step(rng):
    p = sheet(rng, noise=5e-5)
    p[p[:, 0] > 0.0, 2] += 0.003
    return p


def tilted_steps_of_depth(rng):
    p = sheet(rng, noise=3e-4)
    p[:, 2] = 1e-3 * np.round(1e3 * (p[:, 2] + 0.3 * p[:, 0]))
    return p


@pytest.mark.parametrize("shape", [one_ball, box, waves, step, tilted_steps_of_depth])
def test_single_layers_are_not_two(shape):
    assert gap_of(shape(np.random.default_rng(2))) == 0.0


@pytest.mark.parametrize("noise", [0.0, 1e-4, 5e-4, 2e-3])
def test_noise_is_not_two_layers(noise):
    assert gap_of(sheet(np.random.default_rng(3), noise=noise)) == 0.0


def test_front_and_back_of_a_plate_are_apart_by_their_normals():
    rng = np.random.default_rng(4)
    points = np.concatenate([sheet(rng), sheet(rng, z=-0.001)])
    normals = np.repeat([[0, 0, 1.0], [0, 0, -1.0]], 3000, axis=0)
    assert gap_of(points, normals) == 0.0
    assert gap_of(points) > 0.0


def test_the_surface_tells_of_its_layers():
    rng = np.random.default_rng(5)
    cloud = PointCloud(np.concatenate([sheet(rng), sheet(rng, z=0.001)]), viewpoint=[0, 0, 0.3], name="scan")
    with pytest.warns(PalpateWarning, match=r"two layers of points, 0\.9.* mm apart, are felt as one surface"):
        surface = PointSurface(cloud)
    assert "two layers" in str(surface)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert PointSurface(PointCloud(sheet(rng), viewpoint=[0, 0, 0.3])).layer_gap == 0.0
