"""Materials: moduli agree with linear elasticity, and wrong values are refused with their reason."""

import numpy as np
import pytest

from palpate.tissue import PRESETS, TissueMaterial
from palpate.tissue.material import HIGHEST_POISSON


def test_moduli_follow_linear_elasticity():
    m = TissueMaterial(6e3, 0.4)
    assert m.young == pytest.approx(9 * m.bulk * m.shear / (3 * m.bulk + m.shear))
    assert m.poisson == pytest.approx((3 * m.bulk - 2 * m.shear) / (2 * (3 * m.bulk + m.shear)))
    assert TissueMaterial.from_shear(m.shear, 0.4).young == pytest.approx(m.young)


def test_instantaneous_modulus_exceeds_the_one_at_rest_by_the_terms():
    m = TissueMaterial(6e3, HIGHEST_POISSON, prony=((0.5, 0.1), (0.25, 1.0)))
    assert m.instantaneous == pytest.approx(1.75 * m.young, rel=5e-3)  # almost incompressible
    assert TissueMaterial(6e3, 0.4).instantaneous == pytest.approx(6e3)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"young": -5e3}, "young must be a positive number in Pa, got -5000"),
        ({"young": float("nan")}, "young"),
        ({"young": 5e3, "poisson": 0.5}, "incompressible"),
        ({"young": 5e3, "poisson": 0.497}, "outside the range"),
        ({"young": 5e3, "poisson": -0.1}, "outside the range"),
        ({"young": 5e3, "poisson": float("nan")}, "poisson"),
        ({"young": 5e3, "density": 0.0}, "density"),
        ({"young": 5e3, "yeoh": -1.0}, "yeoh"),
        ({"young": 5e3, "prony": ((-0.1, 1.0),)}, r"prony\[0\]"),
        ({"young": 5e3, "prony": ((0.1, 1.0), (0.1, 0.0))}, r"prony\[1\]"),
        ({"young": 5e3, "prony": ((0.1, 1.0),) * 5}, "5 terms"),
    ],
)
def test_wrong_values_are_refused(values, words):
    with pytest.raises(ValueError, match=words):
        TissueMaterial(**values)


def test_presets_have_sources_and_plausible_values():
    assert {"liver", "kidney", "gallbladder", "fat", "silicone_20kPa"} <= set(PRESETS)
    for name, m in PRESETS.items():
        assert len(m.source) > 20, name
        assert 1e3 < m.young < 3e5, name
        assert 1.0 <= m.instantaneous / m.young <= 2.0, name
    assert np.isclose(PRESETS["liver"].shear, 1.8e3)
