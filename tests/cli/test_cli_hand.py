"""`palpate calibrate hand`: from a table of measurements to a hand model that a scene can use."""

import json

import json_contract
import numpy as np
import pytest

from palpate.scene import Scene


@pytest.fixture
def grip(tmp_path):
    """A file with the response of a hand of 0.2 kg, 6 N s/m and 250 N/m to sinusoids, 20 s at 500 Hz."""
    t = np.arange(0, 20, 0.002)
    x, F = np.zeros_like(t), np.zeros_like(t)
    for i, f in enumerate((0.5, 1.25, 2.5, 4, 6.5, 9, 12, 16, 21)):
        w = 2 * np.pi * f
        X = 5e-4 * np.exp(1j * (w * t + i * i))
        x, F = x + X.real, F + ((250 - 0.2 * w**2 + 6j * w) * X).real
    rows = np.stack([t, x, F, x], axis=1)
    np.savetxt(tmp_path / "grip.csv", rows, "%.9g", ",", header="t_s,x_m,F_N,u", comments="")
    return tmp_path / "grip.csv"


def test_measured_grip_gives_a_hand_model(palpate, grip, tmp_path):
    done = palpate("calibrate", "hand", grip, "--out", "mine.yaml", "--json", "hand.json")
    assert done.code == 0, done.err
    report = json.loads((tmp_path / "hand.json").read_text())
    assert set(report) == json_contract.keys("calibrate hand")
    assert report["mass_kg"] == pytest.approx(0.2, rel=0.01)
    assert report["stiffness_N_per_m"] == pytest.approx(250, rel=0.01)
    assert "resonance 5.6 Hz" in done.out
    assert (tmp_path / "mine.png").stat().st_size > 10_000
    scene = Scene.parse("objects: [{shape: organ}]\noperator: {hand: mine.yaml}", str(tmp_path / "s.yaml"))
    assert scene.operator.damping == pytest.approx(6.0, rel=0.01)
    again = palpate("calibrate", "hand", grip, "--out", "mine.yaml")
    assert again.code == 2
    assert "exists already" in again.err


def test_invalid_table_is_reported(palpate, tmp_path):
    (tmp_path / "bad.csv").write_text("time,x\n0,0\n")
    done = palpate("calibrate", "hand", "bad.csv")
    assert done.code == 2
    assert "column t_s is missing" in done.err
