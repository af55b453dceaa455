"""Fig 7 in the report, and the conditioning of the leader's Jacobian."""

import re

import numpy as np
import synthetic_run

import palpate
from palpate.report.elements import conditioning, table


def lengths(html):
    return [float(x) for x in re.findall(r"spring at (\d+) % of its length", html)]


def test_elements_list_deflection_and_force_of_each_axis():
    html = table(synthetic_run.run(3.0))
    x, y, z = (re.findall(r"([+-][\d.]+) (?:mm|N)", row) for row in html.split("<tr>")[2:])
    assert [float(v) for v in x] == [float(v) for v in y] == [0.0] * 4
    spring = synthetic_run.K * synthetic_run.DEPTH
    np.testing.assert_allclose([float(v) for v in z[:2]], [1e3 * synthetic_run.DEPTH, spring], atol=0.02)
    assert abs(float(z[3]) - float(z[1]) - float(z[2])) < 2e-3


def test_springs_are_drawn_as_short_as_they_are_compressed():
    ticks = synthetic_run.run(3.0)
    drawn = lengths(table(ticks))
    assert drawn[::2] == [100.0] * 3  # without deflection
    assert drawn[1::2] == [100.0, 100.0, 38.0]  # only z is pressed: 1 - 1 / 1.6
    ticks["delta_x"][:, 0] = 0.5 * ticks["delta_x"][:, 2]
    assert lengths(table(ticks))[1] == 69.0  # half of the deflection


def test_missing_contact_is_stated():
    assert "Nothing was touched" in table(synthetic_run.run(3.0)[:10])


def test_conditioning_against_singular_values_of_differences():
    ticks = synthetic_run.run(0.05)
    arm, h = palpate.Arm.mtm("left"), 1e-6
    values = conditioning(ticks, arm)
    for q, condition in zip(ticks["q"][::10], values[::10], strict=True):
        J = [(arm.fk(q + h * e)[:3, 3] - arm.fk(q - h * e)[:3, 3]) / (2 * h) for e in np.eye(7)[:3]]
        s = np.linalg.svd(np.array(J).T, compute_uv=False)
        assert abs(condition - s[0] / s[-1]) < 1e-6 * condition
    assert (values >= 1.0).all()
