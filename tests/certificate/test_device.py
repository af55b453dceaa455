"""Certificates of devices: agreement with simulation, their text, and rejected input."""

import json

import numpy as np
import pytest

import palpate
from palpate import _verify
from palpate.arm.hands import PRESETS
from palpate.base.arrays.plain import plain
from palpate.base.errors import PalpateError
from palpate.devices.certificate import classical
from palpate.devices.certificate.device import is_device

NORMAL = PRESETS["normal"]


def rests(device, K, B, spring=True, v0=0.2):
    o = device.axis(device.hands[0], K, B, spring)
    return not _verify.Axis(o).run(duration=6.0, v0=v0, x0=0.0 if spring else 2.0 / (K + o.hand_stiffness),
                                 push=0.0 if spring else 2.0).oscillates  # fmt: skip


@pytest.mark.parametrize("delay", [0.0, 0.0034, 0.009])
@pytest.mark.parametrize("B", [0.0, 6.0])
def test_frictionless_device_oscillates_above_its_limit_and_settles_below(delay, B):
    device = palpate.DeviceModel(0.25, 0.4, 800.0, delay, filter=60.0, hand=NORMAL)
    k = palpate.certify(device, B=B).k_max
    assert rests(device, 0.99 * k, B)
    assert not rests(device, 1.01 * k, B)


def test_dry_friction_raises_the_limit_with_a_marginal_verdict():
    device = palpate.DeviceModel(0.05, 0.05, 1000.0, 0.006, friction=0.5, quantum=1e-6, hand=PRESETS["light"])
    found = palpate.certify(device)
    assert found.k_max > 1.05 * found.k_linear
    between = palpate.certify(device, K=0.5 * (found.k_max + found.k_linear))
    assert between.verdict == "marginal"
    assert "it leans on the device's dry friction" in between.reason
    assert rests(device, 0.97 * found.k_max, 0.0, v0=0.5)


def test_quantisation_without_friction_lowers_the_limit():
    fine, coarse = (
        palpate.DeviceModel(0.5, 0.1, 500.0, 0.002, quantum=q, hand=PRESETS["relaxed"]) for q in (0.0, 5e-5)
    )
    B = 8.0
    assert palpate.certify(coarse, B=B).k_max <= palpate.certify(fine, B=B).k_max


def test_most_critical_hand_sets_the_limit():
    device = palpate.DeviceModel(0.3, 0.6, 1000.0, 0.003)
    all_of = palpate.certify(device)
    relaxed = palpate.certify(palpate.DeviceModel(0.3, 0.6, 1000.0, 0.003, hand=PRESETS["relaxed"]))
    assert all_of.k_max == pytest.approx(relaxed.k_max, rel=0.01)
    assert all_of.worst == "hand relaxed"
    assert list(all_of.hands) == list(PRESETS)


def test_reason_states_limit_and_remedy():
    device = palpate.DeviceModel(0.3, 0.6, 1000.0, 0.009, hand=PRESETS["light"])
    found = palpate.certify(device, K=2000.0, B=0.6)
    assert found.verdict == "unstable"
    assert found.reason.startswith("unstable: 9 ms of delay at 1000 Hz and 0.6 N s/m; stable below ")
    better = palpate.certify(palpate.DeviceModel(0.3, 0.6, 1000.0, 0.006, hand=PRESETS["light"]), B=0.6).k_max
    assert f"3 ms less delay would give {better:.0f}" in found.reason
    assert found.margin == pytest.approx(found.k_max / 2000.0 - 1)


def test_stable_and_its_margin():
    found = palpate.certify(palpate.DeviceModel(0.3, 2.0, hand=NORMAL), K=300.0, B=2.0)
    assert found.verdict == "stable"
    assert "times as stiff" in found.reason
    assert palpate.certify(palpate.DeviceModel(0.3, 2.0, hand=NORMAL), K=0.0).verdict == "stable"


def test_boundary_contains_the_limit_and_json_is_finite():
    found = palpate.certify(palpate.DeviceModel(0.3, 0.6, 1000.0, 0.004, hand=NORMAL), K=500.0, B=3.0)
    B, K = found.boundary(200)
    assert np.interp(3.0, B, K) == pytest.approx(found.k_linear, rel=0.01)
    figures = plain(found.figures())
    assert figures["k_max_N_per_m"] == found.k_max
    assert len(figures["boundary"]) == 48
    json.dumps(figures, allow_nan=False)


def test_classical_bounds():
    assert classical.colgate_brown(3.0, 1.0, 1e-3) == pytest.approx(4000.0)
    assert classical.colgate_brown(3.0, 1.0, 1e-3, 3.5e-3) == pytest.approx(500.0)
    assert classical.colgate_brown(1.0, 2.0, 1e-3) == 0.0
    assert classical.abbott_okamura(1.0, 0.05, 2e-5, 1e-3) == pytest.approx(2000.0)
    assert classical.abbott_okamura(0.1, 0.05, 2e-5, 1e-3) == pytest.approx(200.0)


def test_passive_walls_are_stable():
    """Colgate and Brown's bound, with the hand's damping included, lies below the exact limit."""
    rng = np.random.default_rng(5)
    for _ in range(10):
        device = palpate.DeviceModel(rng.uniform(0.05, 1), rng.uniform(0.5, 5), rng.uniform(300, 3000), hand=NORMAL)
        case = device.loop(NORMAL)
        assert classical.colgate_brown(device.damping + NORMAL.damping, 0.0, case.T) < case.K_max(0.0)[0]


def test_invalid_devices_are_rejected():
    with pytest.raises(PalpateError, match="device mass = 0"):
        palpate.DeviceModel(0.0, 1.0)
    with pytest.raises(PalpateError, match="device rate"):
        palpate.DeviceModel(0.3, 1.0, rate=1.0)


@pytest.mark.parametrize(
    ("text", "expected"),
    [("kind: device\n", True), ("kind: hand\n", False), ("- device\n", False), ("device\n", False), ("{", False)],
)
def test_a_file_of_a_device_says_so(tmp_path, text, expected):
    (tmp_path / "d.yaml").write_text(text)
    assert is_device(tmp_path / "d.yaml") is expected
    assert not is_device(tmp_path / "absent.yaml")
