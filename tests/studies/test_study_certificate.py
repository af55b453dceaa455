import numpy as np
import pytest
from json_contract import keys, keys_of

from palpate.studies.certificate import figures
from palpate.studies.certificate import work as study
from palpate.studies.certificate.arms import table as arms_table


@pytest.fixture(scope="module")
def rows():
    return [{"device": i, **study.judged({"device": i}, seed)} for i, seed in enumerate((3, 4, 7, 11))]


def test_predicted_and_simulated_agree_and_what_is_certified_rests(rows):
    assert all(abs(row["error"]) < study.WITHIN for row in rows)
    assert all(row["certified_broken"] == 0 for row in rows)


def test_the_judge_is_not_the_predictor():
    """It finds the limit of a loop whose closed form is known, from random disturbances alone."""
    device, _ = study.drawn(12)
    smooth = study.Device(device.mass, device.damping, 900.0, 0.004, hand=device.hand)
    exact = smooth.loop(smooth.hands[0]).K_max(1.0)[0]
    assert study.simulated_limit(smooth, 1.0, exact, np.random.default_rng(0)) == pytest.approx(exact, rel=0.01)


def test_devices_are_drawn_by_their_seed():
    assert study.drawn(5) == study.drawn(5) != study.drawn(6)


def test_keys_table_and_picture(rows, tmp_path):
    told = study.summary(rows)
    assert set(told) | {"simulated", "seed", "devices", "arms"} == keys("study certificate")
    assert set(rows[0]) == keys_of("study certificate", "A row of `devices`:")
    assert study.table(told).row_count == 6
    wall = {"scene": "paper", "normal": 0, "B": 5.0, "delay": 0.0, "predicted_N_per_m": 2.0, "simulated_N_per_m": 2.0,
            "error": 0.0, "frequency_Hz": 8.0, "certified_broken": 0.0}  # fmt: skip
    assert set(wall) == keys_of("study certificate", "A row of `arms`:")
    assert arms_table([wall]).row_count == 1
    assert figures.draw(rows, tmp_path).stat().st_size > 10_000
