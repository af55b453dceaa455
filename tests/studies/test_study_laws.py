"""`palpate study laws`: its keys, and results that follow from a mass on a spring."""

from dataclasses import asdict

import json_contract
import numpy as np
import pytest

from palpate.base.sweep.grid import Grid
from palpate_lab.studies.laws import work as laws
from palpate_lab.studies.laws.figures import draw, handle_mass

KEYS = {
    *("law", "f_Hz", "K_N_per_m", "hand", "model_scale", "felt_N_per_m", "felt_damping_N_s_per_m", "stiffness_error"),
    *("impedance_error", "force_error", "force_rms_N", "motion_mm", "peak_speed_m_s", "neglected_N", "too_fast"),
}


@pytest.fixture(scope="module")
def found():
    cases = [laws.Case(law, f, K, "fast") for law in laws.LAWS for f in (1.0, 5.0) for K in (100.0, 400.0)]
    wrong = [laws.Case("stiffness", 5.0, 400.0, "fast", s) for s in (0.7, 1.3)]
    return {laws.Case(**{k: getattr(c, k) for k in ("law", "f_Hz", "K_N_per_m", "hand", "model_scale")}): o
            for c in cases + wrong for o in [laws.experiment(c)]}  # fmt: skip


def of(found, law, f, K, scale=1.0):
    return found[laws.Case(law, f, K, "fast", scale)]


def test_law_of_the_paper_adds_the_mass_of_the_arm_to_the_spring(found):
    """The rendered stiffness is K - m w^2 with the model's mass at the handle."""
    for K in (100.0, 400.0):
        expected = K - handle_mass() * (2 * np.pi * 5.0) ** 2
        assert of(found, "stiffness", 5.0, K).felt_N_per_m == pytest.approx(expected, rel=0.15)
    assert of(found, "stiffness", 1.0, 400.0).stiffness_error < laws.NOTICED
    assert of(found, "stiffness", 5.0, 400.0).too_fast


def test_law_of_the_paper_is_independent_of_model_masses(found):
    felt = [of(found, "stiffness", 5.0, 400.0, s).felt_N_per_m for s in (0.7, 1.0, 1.3)]
    assert np.ptp(felt) < 0.05 * abs(felt[1])


def test_laws_that_shape_the_mass_have_smaller_errors(found):
    for law in ("impedance-shaped", "admittance"):
        for K in (100.0, 400.0):
            assert of(found, law, 5.0, K).stiffness_error < 0.6 * of(found, "stiffness", 5.0, K).stiffness_error
            assert not of(found, law, 5.0, K).too_fast
    assert (
        of(found, "admittance", 1.0, 400.0).impedance_error < 0.3 * of(found, "stiffness", 1.0, 400.0).impedance_error
    )


def test_json_has_the_documented_keys(found):
    row = asdict(next(iter(found.values())))
    assert set(row) == KEYS
    assert json_contract.keys("study laws") == KEYS


def test_bandwidth_is_the_frequency_of_ten_percent_error():
    def outcome(f, error):
        return laws.Outcome("stiffness", f, 400.0, "fast", stiffness_error=error)

    rising = [outcome(f, 0.001 * f**2) for f in (1.0, 5.0, 20.0)]
    assert laws.bandwidth(rising, "stiffness", 400.0, "fast") == pytest.approx(10.0)
    assert laws.bandwidth([outcome(1.0, 0.5)], "stiffness", 400.0, "fast") == 0.0
    assert laws.bandwidth([outcome(1.0, 0.01)], "stiffness", 400.0, "fast") == 1.0


def test_figure_is_drawn(tmp_path):
    points = map(Grid.of(laws.GRID).point, Grid.of(laws.GRID).points(laws.included))
    grid = [laws.Outcome(**p, stiffness_error=0.01 * p["f_Hz"], impedance_error=0.02) for p in points]
    assert len(grid) == len(laws.LAWS) * len(laws.FREQUENCIES) * (len(laws.STIFFNESSES) * len(laws.HANDS) + 2)
    t = np.linspace(0, 1, 50)
    path = draw(grid, [(f"trace {k}", t, np.sin(t), np.cos(t)) for k in range(4)], tmp_path)
    assert path.stat().st_size > 10_000
    assert len(laws.table(grid).rows) == 2 * len(laws.LAWS)
