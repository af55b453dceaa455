"""Hand models from recorded grips: closed forms, presets in the full simulation, and rejected recordings."""

import json
from pathlib import Path

import json_contract
import numpy as np
import pytest
import yaml

from palpate.arm import hands
from palpate.arm.identify import grip_recording
from palpate.arm.identify.hand import Grip, figures, fit
from palpate.base.arrays.plain import plain
from palpate.base.errors import RecordingError
from palpate.record.ticks import as_ticks
from palpate.scene import Scene, rig

GRIP = Path(__file__).parents[2] / "scenes" / "grip.yaml"
TRUE = np.array([0.2, 6.0, 250.0])  # kg, N s/m, N/m
LINES = np.array([0.5, 1, 1.75, 2.5, 3.5, 5, 7.25, 9, 12, 15.5, 20, 25])  # Hz


def pushed(seconds=30.0, rate=1000.0, lines=LINES, wander=0.0, seed=0):
    """(x, F, u): response of a hand with voluntary motion to a force of sinusoids, each by its closed form."""
    rng, t = np.random.default_rng(seed), np.arange(0, seconds, 1 / rate)
    m, b, k = TRUE
    x, F, u = np.zeros_like(t), np.zeros_like(t), np.zeros_like(t)

    def add(f, amplitude, of_hand):
        w, phase = 2 * np.pi * f, rng.uniform(0, 2 * np.pi)
        Z = k - m * w**2 + 1j * w * b  # impedance of the hand; the arm has 0.5 kg, 4 N s/m
        arm = 1j * w * 4.0 - 0.5 * w**2
        wave = amplitude * np.exp(1j * (w * t + phase))
        X = ((k + 1j * w * b) if of_hand else 1.0) * wave / (Z + arm)  # of_hand: voluntary motion [m]
        x[:] += X.real
        F[:] += (-(arm * X) if of_hand else wave - arm * X).real  # Newton's law for the arm
        if not of_hand:
            u[:] += wave.real

    for f in lines:
        add(f, 0.3, False)
    for f in (0.6, 1.4, 3.1, 8.3, 10.1) if wander else ():
        add(f, wander, True)
    return x, F, u


@pytest.mark.parametrize("rate", [200.0, 1000.0])
def test_grip_without_noise_gives_the_true_hand(rate):
    x, F, u = pushed(rate=rate)
    found = fit(Grip(rate, x, F, u))
    # Fourth-order differences: the error (w / rate)^4 / 30 at 25 Hz is 1.3 % at 200 Hz.
    assert found.value == pytest.approx(TRUE, rel=0.02 if rate < 1000 else 1e-3)
    assert found.explained > 0.99
    assert found.warnings == ()
    assert found.resonance == pytest.approx(np.sqrt(250 / 0.2) / 2 / np.pi, rel=0.01)


def test_voluntary_motion_gives_no_bias_with_a_known_excitation():
    x, F, u = pushed(wander=2e-3)
    known, unknown = fit(Grip(1000.0, x, F, u)), fit(Grip(1000.0, x, F))
    assert known.value == pytest.approx(TRUE, rel=0.03)
    assert np.abs(unknown.value / TRUE - 1).max() > 0.1
    assert "nothing in the recording says what shook" in unknown.warnings[0]


def test_confidence_covers_the_truth():
    """With noise on the force, the 95 % intervals of 60 recordings contain the true values nearly always."""
    rng = np.random.default_rng(1)
    x, F, u = pushed(30.0, 250.0)
    inside = []
    for _ in range(60):
        found = fit(Grip(250.0, x + rng.normal(0, 2e-5, len(x)), F + rng.normal(0, 0.3, len(F)), u))
        inside.append((found.interval[:, 0] < TRUE) & (found.interval[:, 1] > TRUE))
    # Binomial for 180 intervals at 95 %; differences at 250 Hz bias the mass by half a percent.
    assert np.mean(inside) > 0.85


def lagging(F, rate, order):
    """The force of a load cell with a low-pass of 100 Hz, by its continuous response; order 0: one that overshoots."""
    from scipy.signal import bessel, butter

    w = 2 * np.pi * 100.0
    b, a = butter(1, w, analog=True) if order < 2 else bessel(order, w, analog=True)
    if order == 0:
        b, a = [w**2], [1.0, 2 * 0.4 * w, w**2]
    s = 2j * np.pi * np.fft.rfftfreq(len(F), 1 / rate)
    return np.fft.irfft(np.fft.rfft(F) * np.polyval(b, s) / np.polyval(a, s), len(F))


@pytest.mark.parametrize("order", [0, 1, 2, 4])
def test_filter_of_the_load_cell_biases_nothing(order):
    """Its lag is found, and the intervals of forty recordings hold the truth."""
    rng, (x, F, u) = np.random.default_rng(5), pushed(28.0, 500.0)
    F, inside, lags = lagging(F, 500.0, order), [], []
    for _ in range(40):
        found = fit(Grip(500.0, x + rng.normal(0, 2e-5, len(x)), F + rng.normal(0, 0.05, len(F)), u))
        inside.append((found.interval[:, 0] < TRUE) & (found.interval[:, 1] > TRUE))
        lags.append(found.lag)
        assert found.value == pytest.approx(TRUE, rel=0.06)
        assert not any("another form" in text for text in found.warnings)
    assert np.mean(inside) >= 0.90
    slope = {0: 0.8, 1: 1.0, 2: 3.0**0.5, 4: 105.0**0.25}[order]  # of the phase at zero, times the cut-off
    assert np.mean(lags) == pytest.approx(slope / (2 * np.pi * 100.0), rel=0.1)


@pytest.mark.parametrize("wrong", ["friction", "saturation", "yielding"])
def test_another_form_of_the_hand_is_told(wrong):
    rng, (x, F, u) = np.random.default_rng(6), pushed(28.0, 500.0)
    if wrong == "friction":
        F = F + 0.1 * np.tanh(np.gradient(x, 1 / 500.0) / 0.005)
    elif wrong == "saturation":
        F = np.clip(F, -1.2 * F.std(), 1.2 * F.std())
    else:  # the fingers' pulp is a spring of 2000 N/m in series
        s = 2j * np.pi * np.fft.rfftfreq(len(F), 1 / 500.0)
        Z = TRUE[0] * s**2 + TRUE[1] * s + TRUE[2]
        F = np.fft.irfft(np.fft.rfft(F) / (1.0 + Z / 2000.0), len(F))
    found = fit(Grip(500.0, x + rng.normal(0, 2e-5, len(x)), F + rng.normal(0, 0.05, len(F)), u))
    assert any("another form" in text for text in found.warnings)


def test_false_alarms_of_the_form_are_rare():
    (x, F, u), rng, p = pushed(28.0, 250.0, wander=1e-3), np.random.default_rng(7), []
    for _ in range(60):
        p.append(fit(Grip(250.0, x + rng.normal(0, 2e-5, len(x)), F + rng.normal(0, 0.1, len(F)), u)).p_misfit)
    assert np.mean(np.array(p) < 0.05) < 0.15


@pytest.mark.parametrize("name", list(hands.PRESETS))
def test_presets_are_identified_from_simulated_sessions(name):
    """Within 10 %, with arm friction, encoder counts, load cell noise of 0.05 N and a tremor of 0.1 mm."""
    scene = yaml.safe_load(GRIP.read_text())
    scene["operator"]["hand"] = name
    scene["operator"]["palpate"]["slide"] = 22
    scene["arms"]["leader"] = {"load_cell_noise": 0.05}
    ticks = as_ticks(rig.build(Scene.model_validate(scene)).simulation().run(24_000))
    found, true = fit(grip_recording.grip_of_ticks(ticks, 1000.0, name)), hands.PRESETS[name]
    assert found.value == pytest.approx([true.mass, true.damping, true.stiffness], rel=0.1)
    assert found.warnings == ()


# ---------------------------------------------------------------- rejected recordings
def assert_rejected(*args, message):
    with pytest.raises(RecordingError) as caught:
        fit(Grip(*args))
    assert message in str(caught.value)


def test_uninformative_grips_are_rejected():
    x, F, u = pushed()
    assert_rejected(1000.0, x[:9000], F[:9000], u[:9000], message="9.0 s of grip are too short")
    assert_rejected(100.0, x, F, u, message="100 Hz is too slow for a hand")
    assert_rejected(1000.0, 0.001 * x, F, u, message="the handle hardly moves")
    assert_rejected(1000.0, x, np.where(F > 0.5, np.nan, F), u, message="not finite")
    assert_rejected(1000.0, x, -F, u, message="x or F has the wrong sign")
    noise = np.random.default_rng(2).normal(size=(3, len(x)))
    assert_rejected(1000.0, 1e-3 * noise[0], noise[1], noise[2], message="frequencies are coherent enough")


def test_excitation_on_one_side_of_the_resonance_is_rejected():
    assert_rejected(1000.0, *pushed(lines=np.arange(0.5, 5.0, 0.5)), message="the mass cannot be identified")
    assert_rejected(1000.0, *pushed(lines=np.arange(6.0, 28.0, 2.0)), message="the stiffness cannot be identified")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n", "column t_s is missing"),
        ("", "column t_s is missing"),
        ("t_s,x_m,F_N\n0,0,0\n1,x,0\n", "grip.csv:3: not a row of numbers"),
        ("t_s,x_m,F_N\n0,0,0\n1,0\n", "grip.csv:3: not a row of numbers"),
        ("t_s,x_m,F_N\n0,0,0\n0,0,0\n0,0,0\n", "t_s must rise"),
        ("t_s,x_m,F_N\n0,0,0\n1,0,0\n3,0,0\n4,0,0\n", "not sampled evenly"),
    ],
)
def test_invalid_tables_are_rejected(tmp_path, text, message):
    (tmp_path / "grip.csv").write_text(text)
    with pytest.raises(RecordingError) as caught:
        grip_recording.load(tmp_path / "grip.csv")
    assert message in str(caught.value)


def test_record_without_contact_is_rejected(tmp_path):
    with pytest.raises(RecordingError, match=r"none\.mcap"):
        grip_recording.load(tmp_path / "none.mcap")
    scene = {"objects": [{"sphere": {"radius": 0.02}}], "operator": {"path": [{"t": 0, "xyz": [0, 0, 0.04]}]}}
    ticks = as_ticks(rig.build(Scene.model_validate(scene)).simulation().run(100))
    with pytest.raises(RecordingError, match="nothing was touched"):
        grip_recording.grip_of_ticks(ticks, 1000.0, "r")


def test_table_gives_the_same_result_as_the_signals(tmp_path):
    x, F, u = pushed(20.0)
    table = np.stack([np.arange(len(x)) * 1e-3, x, F, u], axis=1)
    np.savetxt(tmp_path / "grip.csv", table, "%.9g", ",", header="t_s,x_m,F_N,u", comments="")
    grip = grip_recording.load(tmp_path / "grip.csv")
    assert fit(grip).value == pytest.approx(fit(Grip(1000.0, x, F, u)).value, rel=1e-4)
    report = plain(figures(grip, fit(grip)))
    assert set(report) == json_contract.keys("calibrate hand")
    json.dumps(report, allow_nan=False)
