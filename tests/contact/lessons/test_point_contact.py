"""Section 3.2 of the paper: the normals are collinear at point contact, and only there."""

import numpy as np
import pytest

from palpate.scene.contact.lessons.point_contact import approach
from palpate.world.surfaces import ImplicitSurface

U = ImplicitSurface.of_half_lengths((0.03, 0.025, 0.02), (2, 2, 4))
V = ImplicitSurface.of_half_lengths((0.02, 0.015, 0.015), (4, 2, 2))
TOUCH, WAY = (0.02, 0.01, 0.03), (-1.0, 0.2, -0.8)


def test_normals_become_collinear_as_the_gap_closes():
    pairs = [approach(U, V, TOUCH, WAY, d) for d in 10.0 ** -np.arange(2, 10)]
    gaps, crosses = np.array([(p.gap, p.cross) for p in pairs]).T
    assert (np.diff(gaps) < 0).all()
    assert (np.diff(crosses) < 0).all()
    assert crosses[0] > 0.1
    assert crosses[-1] < 1e-6
    assert pairs[-1].dot < -1 + 1e-12
    assert np.polyfit(np.log(gaps[3:]), np.log(crosses[3:]), 1)[0] == pytest.approx(1.0, abs=0.01)  # linear


def test_bodies_in_contact_touch_in_exactly_one_point():
    pair = approach(U, V, TOUCH, WAY, 0.0)
    assert pair.gap < 1e-15
    np.testing.assert_allclose(U.nearest(pair.y[None])[0], 0.0, atol=1e-15)
    np.testing.assert_allclose(V.nearest((pair.y - pair.p_V)[None])[0], 0.0, atol=1e-12)
    inside_V = V.nearest(U.vertices - pair.p_V)[0]
    assert inside_V.min() > -1e-12


def test_direction_that_does_not_approach_the_object_is_rejected():
    with pytest.raises(ValueError, match="does not lead into U"):
        approach(U, V, TOUCH, (1.0, 0.0, 1.0), 0.01)
