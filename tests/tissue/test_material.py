"""Materials: moduli agree with linear elasticity, and wrong values are refused with their reason."""

import numpy as np
import pytest
import soft_bodies
from strained import SHEAR, cycle_moduli, once

from palpate.world.tissue import MEASUREMENTS, PRESETS, TissueMaterial
from palpate.world.tissue.material import HIGHEST_POISSON, LARGEST_SHARE, LONGEST_TAU, MOST_TERMS, SHORTEST_TAU
from palpate.world.tissue.viscosity import complex_modulus


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
        ({"young": 5e3, "prony": ((0.1, 1e-6),)}, "from 1e-05 to 1000 s, got 1e-06"),
        ({"young": 5e3, "prony": ((0.1, 2e3),)}, "from 1e-05 to 1000 s, got 2000"),
        ({"young": 5e3, "prony": ((60.0, 1.0), (41.0, 0.1))}, "sum to 101, more than 100"),
    ],
)
def test_wrong_values_are_refused(values, words):
    with pytest.raises(ValueError, match=words):
        TissueMaterial(**values)


def test_the_core_accepts_the_same_prony_terms_and_no_others():
    mesh = soft_bodies.box((1, 1, 1), (0.01,) * 3)
    for tau in (SHORTEST_TAU, LONGEST_TAU):
        soft_bodies.body(mesh, prony=[(LARGEST_SHARE / MOST_TERMS, tau)] * MOST_TERMS)
    for prony in ([(1.0, 0.99 * SHORTEST_TAU)], [(1.0, 1.01 * LONGEST_TAU)], [(1.01 * LARGEST_SHARE, 1.0)]):
        with pytest.raises(ValueError, match="prony"):
            soft_bodies.body(mesh, prony=prony)


def test_presets_have_sources_and_plausible_values():
    assert {"liver", "kidney", "gallbladder", "fat", "silicone_20kPa"} <= set(PRESETS)
    assert set(MEASUREMENTS) == set(PRESETS)
    for name, m in PRESETS.items():
        assert str(MEASUREMENTS[name]) == m.source
        assert MEASUREMENTS[name].strain, name
        assert 1e3 < m.young < 3e5, name
        assert 1.0 <= m.instantaneous / m.young <= 2.0, name
    assert np.isclose(PRESETS["liver"].shear, 1.8e3), "quasi-static"
    assert PRESETS["silicone_60kPa"].young == pytest.approx(60e3)


@pytest.mark.parametrize("name", PRESETS)
def test_presets_have_the_measured_modulus_at_the_frequency_of_the_measurement(name):
    """The running element in a steady shear, and the closed form, against the published value."""
    m, measured = PRESETS[name], MEASUREMENTS[name]
    closed = m.shear * abs(complex_modulus(m.prony, measured.frequency))
    assert closed == pytest.approx(measured.shear, rel=1e-9)
    if measured.frequency == 0.0:
        found = once(m.poisson, [], SHEAR, young=m.young)  # nothing relaxes any more
    else:
        omega = 2.0 * np.pi * measured.frequency
        prony = [(g, min(tau, 0.3)) for g, tau in m.prony]  # slower terms are stiff at this frequency all the same
        found = abs(cycle_moduli(m.poisson, prony, SHEAR, omega, 1.0 / measured.frequency / 64, young=m.young))
    assert found / 2.0 == pytest.approx(measured.shear, rel=0.01)
