"""The noise that a scan states, against the noise that was put in, where the points lie closer than their noise."""

import numpy as np
import pytest

from palpate.world.clouds import PointCloud
from palpate.world.scan import scan


@pytest.mark.parametrize("noise", [2e-4, 8e-4, 1.6e-3])
def test_noise_of_a_dense_view_is_that_of_its_points(noise):
    """40,000 points 0.5 mm apart: the former estimate, from 64 neighbours, read 0.83 and 0.6 of the larger noises."""
    pytest.importorskip("small_gicp", reason="extra registration")
    rng = np.random.default_rng(4)
    x, y = rng.uniform(-0.05, 0.05, (2, 40_000))
    z = 0.3 + 0.01 * np.sin(25.0 * x) + noise * rng.normal(size=len(x))
    found = scan([PointCloud(np.column_stack([x, y, z]))])
    across = np.mean(1.0 / np.sqrt(1.0 + np.square(0.25 * np.cos(25.0 * x))))  # the noise lies along z
    assert found.noise == pytest.approx(noise * across, rel=0.06)
