"""The limit of a wrist axis from simulated recordings of known truth, and recordings that do not determine it."""

import json
from dataclasses import replace

import numpy as np
import pytest
from json_contract import keys

import palpate
from palpate.arm.hands import Hand
from palpate.base.errors import RecordingError
from palpate.cli import main
from palpate.devices.wrist import COLUMNS, LEVER, certify_wrist, load

DT = 1e-3
# A roll axis as heavy in friction as an MTM's: inertia, damping, friction, delay, encoder step.
TRUTH = {"I": 1.2e-4, "b": 4e-4, "c": 4e-3, "delay": 3, "step": 2e-5}
SECONDS = 8.0


def torque(size, seconds=SECONDS):
    """Alternating, with half periods of 60, 90 and 130 ms in turn."""
    signs = np.concatenate([np.full(n, (-1.0) ** k) for k, n in enumerate([60, 90, 130] * 40)])
    return size * signs[: round(seconds / DT)]


def record(tau, I, b, c, delay, step):  # noqa: E741
    """Angles of the axis: exact stick and slip by small steps of an implicit friction, encoder counts."""
    late, fine = np.concatenate([np.zeros(delay), tau[: len(tau) - delay]]), 20
    h, a, v, out = DT / 20, 0.0, 0.0, []
    for u in late:
        out.append(a)
        for _ in range(fine):
            free = (v + h * u / I) / (1.0 + h * b / I)
            v = np.sign(free) * max(0.0, abs(free) - h * c / I)
            a += h * v
    angle = np.array(out)
    return DT * np.arange(len(tau)), step * np.round(angle / step) if step else angle


@pytest.fixture(scope="module")
def recording():
    tau = torque(0.02)
    t, angle = record(tau, **TRUTH)
    return t, angle, tau


@pytest.fixture(scope="module")
def found(recording):
    return certify_wrist(*recording, K=0.01, B=1e-3)


def true_limit(B):
    """Of the axis itself, without identification."""
    L2 = LEVER**2
    o = palpate._core.HandOptions()
    hands = (Hand("free", 1e-4, 1e-3, 1e-2), Hand("held", o.inertia / L2, o.rotational_damping / L2, 1.5 / L2))
    device = palpate.DeviceModel(
        TRUTH["I"] / L2,
        TRUTH["b"] / L2,
        delay=0.0035,
        quantum=TRUTH["step"] * LEVER,
        friction=TRUTH["c"] / LEVER,
        hand=hands,
    )
    return L2 * palpate.certify(device, B=B / L2).k_max


def test_the_axis_and_its_limit_are_found(found):
    for key, truth, error in (("mass", "I", 0.05), ("damping", "b", 0.3), ("friction", "c", 0.1)):
        assert found.spread(key) == pytest.approx((TRUTH[truth],) * 2, rel=error), key
    assert found.spread("delay") == pytest.approx((0.003, 0.003), abs=1e-4)  # a tenth of a period
    assert found.resolution_rad == pytest.approx(TRUTH["step"], rel=1e-3)
    assert found.uncertain() == []
    truth = true_limit(1e-3)
    assert found.k_max == pytest.approx(truth, rel=0.1)
    assert found.k_max <= 1.02 * truth
    assert found.verdict == "stable"


def test_the_linear_limit_does_not_depend_on_the_lever(found, recording, monkeypatch):
    monkeypatch.setattr("palpate.devices.wrist.LEVER", 0.1)
    other = certify_wrist(*recording, B=1e-3)
    assert other.k_linear == pytest.approx(found.k_linear, rel=0.02)


def test_values_that_differ_between_the_parts_are_named(found):
    fits = tuple(replace(fit, damping=fit.damping * (1 + 3 * i)) for i, fit in enumerate(found.fits))
    assert replace(found, fits=fits).uncertain() == ["damping"]


def test_a_free_decay_does_not_determine_a_stiffness(recording):
    t, angle, tau = recording
    with pytest.raises(RecordingError, match=r"(?s)the torque changes its sign 0 times.*damping / inertia.*no delay"):
        certify_wrist(t, angle, np.zeros_like(tau))


def test_a_torque_below_the_friction_does_not_determine_the_inertia():
    tau = torque(0.003)
    t, angle = record(tau, **TRUTH)
    with pytest.raises(RecordingError, match=r"(?s)inertia is not identifiable.*hardly moved under 0\.003 N m"):
        certify_wrist(t, angle, tau)


@pytest.mark.parametrize(
    ("text", "message"),
    [("time_s,angle_rad\n0,0\n", "no column torque_Nm"), ("time_s,angle_rad,torque_Nm\n0,0,nan\n", "no finite number"),
     ("time_s,angle_rad,torque_Nm\n0,0,0\n", "1 rows are too few"), ("", "no column time_s"),
     ("time_s,angle_rad,torque_Nm\n0,0,one\n", "cannot be read")],
)  # fmt: skip
def test_files_that_are_no_recording(tmp_path, text, message):
    (tmp_path / "w.csv").write_text(text)
    with pytest.raises(RecordingError, match=message):
        load(tmp_path / "w.csv")


def test_command(recording, tmp_path):
    csv, out = tmp_path / "w.csv", tmp_path / "o.json"
    np.savetxt(csv, np.column_stack(recording), delimiter=",", header=",".join(COLUMNS), comments="")
    assert main(["device", "wrist", str(csv), "--stiffness", "50", "--json", str(out)]) == 0
    found = json.loads(out.read_text())
    assert set(found) == keys("device wrist")
    assert found["verdict"] == "unstable"
