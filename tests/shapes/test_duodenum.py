"""The generated duodenum: a closed tube, wound outwards, the same on every call."""

import numpy as np
import pytest

from palpate import Mesh
from palpate.world import shapes


@pytest.mark.parametrize("triangles", [2000, 8000])
def test_the_duodenum_is_closed_and_wound_outwards(triangles: int) -> None:
    v, t = shapes.duodenum(triangles)
    mesh = Mesh(v, t)
    assert mesh.report.watertight
    assert mesh.report.inverted == 0
    assert mesh.report.volume_m3 == pytest.approx(np.pi * 0.0125**2 * 0.19, rel=0.25)
    assert len(t) == pytest.approx(triangles, rel=0.1)
    np.testing.assert_allclose(v.min(axis=0) + v.max(axis=0), 0.0, atol=1e-12)
    np.testing.assert_array_equal(v, shapes.duodenum(triangles)[0])


def test_too_few_triangles_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 2000"):
        shapes.duodenum(100)
