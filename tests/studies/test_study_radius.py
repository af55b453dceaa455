"""`palpate study radius`: the documented keys and a figure. tests/contact/test_touchable.py tests the map."""

from functools import partial

import json_contract
import numpy as np

from palpate.base.sweep import sweep
from palpate_lab.studies.radius import spheres
from palpate_lab.studies.radius import work as radius
from palpate_lab.studies.radius.figures import draw


def test_rows_table_and_figure(tmp_path):
    serial = partial(sweep, executor="serial")
    rows = radius.run(radii=(1e-3, 2e-3), features=(4e-3,), noises=(0.0, 0.2e-3), sweep=serial)
    assert {key for row in rows for key in row} == json_contract.keys("study radius")
    assert rows[0]["error_mN"] == 0.0  # without noise
    assert "kept of" in radius.table(rows).columns[1].header
    assert draw(rows, tmp_path).stat().st_size > 10_000


def test_rate_filter_only_adds_a_lag():
    """A ramp below the rate cap is unchanged; a step becomes a ramp."""
    ramp = np.linspace(1.0, 2.0, 1000)[:, None] * [0, 0, 1]
    np.testing.assert_allclose(radius.rate_limited(ramp, 5.0), ramp, atol=1e-12)
    step = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, 1.5]], 500, axis=0)
    limited = radius.rate_limited(step, 5.0)[:, 2]
    assert limited[500 + 98] < 1.5 - 1e-9
    assert limited[500 + 101] == 1.5


def test_spheres_show_what_removing_the_noise_gains():
    found = spheres.spheres(triangles=5_000, spacing=4e-3, places=20)
    rows = {key for name in ("meshes", "clouds") for row in found[name] for key in row}
    assert set(found) | rows == json_contract.keys_of("study radius", "With `--spheres`:")
    assert all(row["smoothed_deg"] < 0.5 * row["direction_deg"] for row in found["meshes"])
    assert len(found["clouds"]) == len(spheres.CLOUD_NOISES) * len(spheres.RADII)
    assert all(row["direction_deg"] < 5.0 for row in found["clouds"])
    assert [table.row_count for table in spheres.table(found)] == [2, 10]
