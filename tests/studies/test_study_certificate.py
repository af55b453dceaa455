import numpy as np
import pytest
from json_contract import keys, keys_of

from palpate.studies.certificate import figures
from palpate.studies.certificate import work as study
from palpate.studies.certificate.arms import table as arms_table


@pytest.fixture(scope="module")
def rows():
    return [{"device": i, **study.judged({"device": i}, seed)} for i, seed in enumerate((3, 4, 7, 11))]


def test_predicted_limits_agree_with_simulated_ones_and_certified_loops_settle(rows):
    assert all(abs(row["error"]) < study.WITHIN for row in rows)
    assert all(row["certified_broken"] == 0 for row in rows)


def test_simulated_limit_agrees_with_a_closed_form():
    """The simulation finds the limit of a loop with a closed form from random disturbances."""
    device, _ = study.drawn(12)
    smooth = study.DeviceModel(device.mass, device.damping, 900.0, 0.004, hand=device.hand)
    exact = smooth.loop(smooth.hands[0]).K_max(1.0)[0]
    assert study.simulated_limit(smooth, 1.0, exact, np.random.default_rng(0)) == pytest.approx(exact, rel=0.01)


def test_devices_depend_on_the_seed():
    assert study.drawn(5) == study.drawn(5) != study.drawn(6)


def test_keys_table_and_figure(rows, tmp_path):
    summary = study.summary(rows)
    assert set(summary) | {"simulated", "seed", "devices", "arms"} == keys("study certificate")
    assert set(rows[0]) == keys_of("study certificate", "A row of `devices`:")
    assert study.table(summary).row_count == 6
    wall = {"scene": "paper", "normal": 0, "B": 5.0, "delay": 0.0, "predicted_N_per_m": 2.0, "simulated_N_per_m": 2.0,
            "error": 0.0, "frequency_Hz": 8.0, "certified_broken": 0.0}  # fmt: skip
    assert set(wall) == keys_of("study certificate", "A row of `arms`:")
    assert arms_table([wall]).row_count == 1
    assert figures.draw(rows, tmp_path).stat().st_size > 10_000
