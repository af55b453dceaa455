"""Contact with clouds against contact with meshes, and on clouds of real cameras."""

import os
from pathlib import Path

import numpy as np
import pytest

from palpate import PointCloud
from palpate.scene import contact
from palpate.world import surfaces
from palpate_lab.verify.bench import cloud_organ

DATA = Path(os.environ.get("PALPATE_DATA") or Path(__file__).resolve().parents[3] / "shared" / "data") / "clouds"
KINECT = sorted(DATA.glob("*.pcd"))


@pytest.mark.parametrize(("noise", "size", "angle"), [(0.0, 0.02, 1.0), (0.3e-3, 0.05, 1.5), (1e-3, 0.09, 2.7)])
def test_a_cloud_of_the_organ_is_felt_as_its_mesh(noise, size, angle):
    found = cloud_organ.difference(noise=noise)
    assert found[0] < size
    assert found[1] < angle


def test_the_comparison_sees_a_cloud_in_another_place(monkeypatch):
    place = cloud_organ.sampled
    monkeypatch.setattr(cloud_organ, "sampled", lambda *args: place(*args) + np.array([0.0, 0.0, 5e-4]))
    assert cloud_organ.difference(noise=0.0)[0] > 0.1


@pytest.mark.skipif(not KINECT, reason="the recorded clouds of a Kinect are not here")
@pytest.mark.parametrize("path", KINECT, ids=[path.stem for path in KINECT])
def test_clouds_of_a_real_camera_can_be_touched(path):
    cloud = PointCloud.load(path, unit="m")
    middle = cloud.points[np.argmin(np.linalg.norm(cloud.points - np.median(cloud.points, axis=0), axis=1))]
    near = cloud.points[np.linalg.norm(cloud.points - middle, axis=1) < 0.15]
    surface = surfaces.PointSurface(PointCloud(near, viewpoint=[0.0, 0.0, 0.0]))
    sight = middle / np.linalg.norm(middle)
    tips = middle + np.linspace(-0.03, 0.005, 300)[:, None] * sight
    force = contact.render(surface, tips, radius=0.01, stiffness=400.0).force
    assert np.isfinite(force).all()
    assert np.linalg.norm(force, axis=1).max() <= 400.0 * 0.05
    assert force[-1] @ -sight > 0.5
