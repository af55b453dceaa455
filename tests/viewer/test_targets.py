"""Ellipsoids of a registration's targets: their shape against the covariance, and in a real browser."""

import io
import time
from dataclasses import replace

import numpy as np
import pytest
from browser import on_screen, open_page
from fake_session import FakeSession, stage
from PIL import Image

from palpate.base.arrays import so3
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.viewer.live import LiveViewer
from palpate.viewer.stage import TargetMark
from palpate.viewer.staging import stage_of
from palpate.viewer.targets import LARGER, axes

PLACE = np.array([-0.03, -0.02, 0.01])


def test_axes_are_those_of_the_covariance():
    rng = np.random.default_rng(0)
    A = rng.normal(size=(3, 3))
    S = 1e-6 * A @ A.T
    wxyz, sizes = axes(S)
    R = so3.matrices(wxyz)
    assert R @ np.diag(sizes**2) @ R.T == pytest.approx(S, abs=1e-15)
    assert axes(np.zeros((3, 3)))[1].min() > 0.0


def test_targets_of_a_scene_have_the_error_of_their_frame():
    made = stage_of(build(Scene.parse(
        "frames: [{child: anatomy, pose: {xyz: [0.1, 0, 0]}, sigma_mm: 1, sigma_deg: 1}]\n"
        "objects: [{name: ball, sphere: {radius: 0.03}, frame: anatomy}]\n"
        "registration: {frame: anatomy, targets: {a: [0, 0, 0], b: [0, 0, 0.02]}, camera: {frame: anatomy}}\n"
    )))  # fmt: skip
    a, b = made.targets
    assert (a.name, b.name) == ("a", "b")
    assert b.p_W == pytest.approx([0.1, 0.0, 0.02])
    assert a.covariance == pytest.approx(1e-6 * np.eye(3), abs=1e-15)
    lever = (0.02 * np.radians(1.0)) ** 2
    assert np.diag(b.covariance) == pytest.approx([1e-6 + lever, 1e-6 + lever, 1e-6])


def test_ellipsoid_is_seen_in_the_organ_and_follows_a_running_registration():
    newest = [PLACE, np.diag([1e-6, 1e-6, 4e-6])]
    mark = TargetMark("tumour", PLACE, newest[1], lambda: (newest[0], newest[1]))
    viewer = LiveViewer(FakeSession(), replace(stage(), targets=(mark,)), port=0)
    try:
        drawing = viewer._drawing.targets[0]
        sizes = sorted(drawing.ellipsoid.scale)
        assert sizes == pytest.approx(LARGER * 2.7955e-3 * np.array([1.0, 1.0, 2.0]), rel=1e-3)
        assert "TRE 2.45 mm rms" in drawing.label.text
        with open_page(viewer.url) as page:
            gold = seen(page, viewer, PLACE)
            assert gold > 20  # pixels
            newest[:] = [PLACE + np.array([0.0, 0.0, 0.02]), 0.04 * newest[1]]
            end = time.monotonic() + 60.0
            while seen(page, viewer, PLACE + np.array([0.0, 0.0, 0.02])) > 0.5 * gold:
                assert time.monotonic() < end
            assert "TRE 0.49 mm rms" in drawing.label.text
            assert page.errors == []
    finally:
        viewer.close()


def seen(page, viewer, p_W):
    """Number of golden pixels around a place."""
    time.sleep(0.5)
    x, y = map(round, on_screen(page, viewer._server, p_W))
    picture = np.asarray(Image.open(io.BytesIO(page.screenshot())).convert("RGB")).astype(float)
    part = picture[y - 25 : y + 25, x - 25 : x + 25]
    return int(((part[..., 1] > 1.5 * part[..., 2]) & (part[..., 0] > part[..., 1])).sum())
