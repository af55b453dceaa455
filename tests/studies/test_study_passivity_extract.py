"""`palpate study passivity --extract`: its exact energy, its motions, and what they take out."""

import json
from dataclasses import replace

import json_contract
import numpy as np
import pytest

from palpate import _core
from palpate.cli import main
from palpate_lab.studies.passivity import extract
from palpate_lab.studies.passivity.extract import CASES, PERIOD, Setting, Strokes

A = 5.0


@pytest.fixture
def motion():
    return extract.strokes(np.random.default_rng(3), A)


def test_strokes_have_the_acceleration_at_every_moment_and_end_at_rest(motion):
    """A stroke of length L takes 2 sqrt(L / A); position and velocity are continuous."""
    np.testing.assert_array_equal(np.abs(motion.a), A)
    for at in (motion.t[1:] - 1e-9, motion.t[1:] + 1e-9):
        x, v = motion.at(at)
        np.testing.assert_allclose(x, motion.x[1:], atol=1e-9)
        np.testing.assert_allclose(v, motion.v[1:], atol=1e-7)
    np.testing.assert_allclose(np.diff(motion.t[::2]), 2.0 * np.sqrt(np.abs(np.diff(motion.x[::2])) / A))
    assert extract.REACH[0] <= motion.x.min() < motion.x.max() <= extract.REACH[1]
    assert motion.t[-1] < extract.SECONDS < motion.t[-2] + 1.0


def test_energy_is_that_of_a_fine_sum(motion):
    """Reference: the sum of force times displacement on a grid of a microsecond, with forces that act late.

    Each of the 3000 changes of the force is off by half a microsecond at up to 0.2 m/s: 0.1 uJ each, 5 uJ in all.
    """
    rng = np.random.default_rng(0)
    acts = np.maximum.accumulate(PERIOD * np.arange(3000) + 0.004 + 0.01 * rng.uniform(size=3000))
    F = rng.normal(size=3000)
    t = np.arange(acts[0], acts[-1], 1e-6)
    acting = F[np.searchsorted(acts, t, side="right") - 1]
    fine = np.cumsum(acting[:-1] * np.diff(motion.at(t)[0])).max()
    assert extract.largest_return(motion, acts, F) == pytest.approx(fine, abs=5e-6)


def test_a_force_that_only_pushes_back_takes_nothing_out(motion):
    """A force that was there before the press returns its energy: 1 N over 10 mm are 10 mJ."""
    out_and_in = Strokes(*np.array([(0.0, 0.0, 0.0, A), (1.0, 0.01, 0.0, 0.0), (9.0, 0.01, 0.0, 0.0)]).T)
    late = replace(out_and_in, t=np.array([0.0, np.sqrt(0.02 / A), 9.0]))
    acts = np.array([0.0, 1.0])
    assert extract.largest_return(late, acts, np.array([1.0, 1.0])) == pytest.approx(0.01)
    assert extract.largest_return(late, acts, np.array([-1.0, -1.0])) == 0.0


@pytest.mark.parametrize("case", ["no delay", "delay of 5 ms", "delay of 20 ms"])
def test_exact_positions_and_whole_delays_keep_the_allowance(case):
    """The guarantee of the layer; the same motions without the layer take out more."""
    with_layer, without = zip(*(
        [extract.extracted(CASES[case], seed, mode) for mode in ("observer", "off")] for seed in range(6)
    ), strict=True)  # fmt: skip
    allowance = _core.StabilityOptions().allowance
    assert max(with_layer) <= allowance + 1e-9
    assert max(without) > 2.0 * allowance


def test_the_layer_knows_the_mean_delay_and_the_counts(monkeypatch):
    seen = []
    monkeypatch.setattr(extract, "rendered", lambda m, t, o, K, s: seen.append((o.delay, o.quantum)) or 0.0 * t)
    extract.extracted(Setting(0.004, 0.010, 20e-6), 0)
    assert seen == [(pytest.approx(0.009), 20e-6)]


def test_command_writes_the_documented_keys(tmp_path, monkeypatch):
    monkeypatch.setattr(extract, "MOTIONS", 2)
    monkeypatch.setattr(extract, "CASES", {name: CASES[name] for name in ("no delay", "delay of 3.37 ms")})
    file = tmp_path / "extract.json"
    command = ["study", "passivity", "--extract", "--json", str(file), "--out", str(tmp_path / "x.nc")]
    assert main([*command, "--figures", str(tmp_path), "--workers", "1"]) == 0
    found = json.loads(file.read_text())
    assert {*found, *found["extract"][0]} | {"case"} == json_contract.keys_of(
        "study passivity", "With `--extract` the keys are"
    )
    assert [row["case"] for row in found["extract"]] == ["no delay", "delay of 3.37 ms"]
    assert all(0.0 <= row["extracted_J"] <= row["without_J"] for row in found["extract"])
