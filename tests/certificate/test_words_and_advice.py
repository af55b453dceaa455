"""Words, advice and transfer functions of certificates against hand-written numbers, scipy and plain averages."""

import numpy as np
import pytest
from scipy import signal

import palpate
from palpate import _core
from palpate.arm.hands import PRESETS
from palpate.devices.certificate import arms, certify_all, words
from palpate.devices.certificate.certificate import Case, advice
from palpate.devices.certificate.scene import _servo_lag

FACTS = words.LoopFacts(0.009, 1000.0, 0.6, 12.34, "hand light")


@pytest.mark.parametrize(
    ("k", "text"),
    [
        *((2274.0, "2270"), (123456.0, "123000"), (999.0, "999"), (23.46, "23.5"), (1.234, "1.23"), (0.1234, "0.123")),
        *((10.0, "10.0"), (0.0, "0"), (np.inf, "any")),
    ],
)
def test_a_stiffness_has_three_digits_and_no_exponent(k, text):
    assert words.number(k) == text


def test_a_loop_in_words():
    assert FACTS.summary() == "9 ms of delay at 1000 Hz and 0.6 N s/m"
    servo = words.LoopFacts(0.0, 500.0, 2.0, 1.0, "", ", 3 ms of the follower's servo")
    assert servo.summary() == "no delay at 500 Hz, 3 ms of the follower's servo and 2 N s/m"


def test_the_reason_states_the_limit_and_what_raises_it_by_15_percent():
    def reason(K, k_max, verdict, **gains):
        return words.reason(K, k_max, verdict, FACTS, [(name, lambda k=k: k) for name, k in gains.items()])

    swing = "it would swing at 12.3 Hz, hand light"
    loop = FACTS.summary()
    assert reason(500.0, np.inf, "stable") == "stable: nothing is too stiff for this loop"
    assert reason(500.0, 0.5, "unstable") == f"unstable: {loop}; stable below 0.500 N/m ({swing})"
    assert reason(500.0, 0.0, "unstable") == f"unstable: {loop}; that is too much damping, whatever the stiffness"
    stable = f"stable: {loop}; 100 N/m could be 3.1 times as stiff, 310 N/m (beyond, {swing})"
    assert reason(100.0, 310.0, "stable", less=870.0) == stable
    assert "100 N/m is near the limit, 109 N/m" in reason(100.0, 109.0, "stable")
    assert "could be 1.1 times" in reason(100.0, 111.0, "stable")
    text = f"unstable: {loop}; stable below 310 N/m ({swing}); more would give 870; less would give 357"
    assert reason(500.0, 310.0, "unstable", none=356.0, less=357.0, more=870.0) == text
    assert reason(None, 310.0, None) == f"{loop}; stable below 310 N/m ({swing})"


class Loop:
    """A loop whose limit falls with the delay and has its peak at 2 N s/m."""

    def __init__(self, delay, B_max, top):
        self.delay, self.B_max, self.top = delay, B_max, top

    def delayed(self, delay):
        return Loop(delay, self.B_max, self.top)

    def K_max(self, B):
        return self.top - 1e4 * self.delay - (B - 2.0) ** 2, 1.0


@pytest.mark.parametrize(
    ("delays", "B", "B_max", "change", "limit", "damping", "peak"),
    [
        ((0.009, 0.002), 0.0, 30.0, "3 ms less delay", 436.0, "1.8 N s/m of damping", 410.0),
        ((0.002, 0.0012), 5.0, 30.0, "1 ms less delay", 481.0, "only 1.8 N s/m of damping", 480.0),
        ((0.0012, 0.0), 0.0, 4.0, "0.4 ms less delay", 488.0, "2.1 N s/m of damping", 488.0),
        ((0.0, 0.0), 10.0, 100.0, None, None, "only 3.6 N s/m of damping", 497.56),
        ((0.0, 0.0), 0.0, 4.0, None, None, "2.1 N s/m of damping", 500.0),
    ],
)
def test_advice_is_less_delay_and_the_best_damping_of_all_cases(delays, B, B_max, change, limit, damping, peak):
    """The first case sets the limit; less delay never makes a delay negative."""
    cases = tuple(Case("", Loop(delay, B_max, 500.0)) for delay in delays)
    found = {text: k() for text, k in advice(cases, B)}
    assert list(found) == [text for text in (change, damping) if text]
    if change:
        assert found[change] == pytest.approx(limit, abs=0.01)
    assert found[damping] == pytest.approx(peak, abs=0.1)


def frequencies(T):
    return np.exp(1j * T * np.array([1.0, 20.0, 300.0, 2000.0]))


def test_velocity_over_a_window_is_the_mean_of_the_velocities_in_it():
    T, window = 1e-3, 0.005
    ages = (np.arange(4000) + 0.5) / 4000 * window
    z = frequencies(T)
    mean = np.exp(-np.log(z)[:, None] / T * ages).mean(axis=1)
    np.testing.assert_allclose(arms._velocity(0.7, window, T)(z), 0.7 * mean, rtol=1e-5)
    np.testing.assert_allclose(arms._velocity(0.7, 0.0, T)(z), 0.7)


@pytest.mark.parametrize(("method", "late"), [("proxy", 0), ("paper-alg1", 4)])
def test_depth_follows_the_goal_through_the_followers_servo(method, late):
    """Reference: scipy's discretisation of x'' = w^2 (goal - x) - 2 zeta w x' with a held goal."""
    o = _core.SimulationOptions()
    o.method, o.rate = method, 1000.0
    o.follower.bandwidth, o.follower.damping_ratio, o.contact.collision_rate = 30.0, 0.6, 250.0
    w = 2.0 * np.pi * 30.0
    servo = signal.cont2discrete((np.array([w * w]), np.array([1.0, 1.2 * w, w * w])), 1e-3, method="zoh")
    z = frequencies(1e-3)
    reference = np.polyval(servo[0].ravel(), z) / np.polyval(servo[1], z) * z**-late
    np.testing.assert_allclose(arms._depth(o, 0.5)(z), 0.5 * reference, rtol=1e-8)
    o.follower.bandwidth = 0.0  # the follower stands at its goal one cycle later
    np.testing.assert_allclose(arms._depth(o, 0.5)(z), 0.5 / z * z**-late, rtol=1e-12)


def test_the_delay_of_a_scene_is_in_whole_periods_of_the_drives():
    o = _core.SimulationOptions()
    o.rate, o.plant_rate, o.loop_jitter = 1000.0, 1900.0, 0.0004
    for delay, periods in ((0.0, 1), (0.0012, 3), (0.0031, 7)):  # of 0.5 ms, with the jitter
        o.loop_delay = delay
        assert arms.whole_servo_periods(o) == pytest.approx(periods * 0.0005)


def test_drives_and_filters_are_first_order_lags():
    """Reference: a mass of 2 kg, whose position and velocity pass 1 / (1 + lag s) and w / (w + s)."""
    o = _core.LeaderOptions()
    o.drive_lag, o.velocity_cutoff = 0.004, 50.0
    A, b = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [0.5]])
    A, b, c, d = arms._with_lags(A, b, np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]]), o)
    s, w = 70.0j, 2.0 * np.pi * 50.0
    x = np.linalg.solve(s * np.eye(len(A)) - A, b)
    assert (c @ x).item() == pytest.approx(1.0 / (2.0 * s * s) / (1.0 + 0.004 * s))
    assert (d @ x).item() == pytest.approx(1.0 / (2.0 * s) / (1.0 + 0.004 * s) * w / (w + s))


def test_reasons_of_a_scene_name_servo_passivity_and_entry():
    scene = palpate.Scene.parse("""
objects: [{name: table, plane: {size: 0.3}, stiffness: 800, damping: 1}]
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}, {t: 1, xyz: [0, 0, 0.019]}]}
mapping: {scale: 0.5}
loop_delay: 0.01
guidance: [{name: wall, role: forbid, geometry: {plane: {}}, law: {stiffness: 500, damping: 1}}]
""")
    table, wall = certify_all(scene, K=60000.0)
    lag = 1e3 * _core.SimulationOptions().follower.damping_ratio / (np.pi * scene.arms.follower.bandwidth)
    assert table.verdict == wall.verdict == "unstable"
    assert f"10 ms of delay at 1000 Hz, {lag:.3g} ms of the follower's servo and 1 N s/m; stable below" in table.reason
    assert f"a follower's servo of {2 * scene.arms.follower.bandwidth:g} Hz would give" in table.reason
    assert "10 ms of delay at 1000 Hz and 1 N s/m; stable below" in wall.reason
    assert "servo" not in wall.reason
    depths = ", ".join(f"{1e3 * F / (scene.mapping.force_scale * 0.97 * wall.k_max):.2g}" for F in (1, 2, 3))
    assert (
        f"softly it can hold so much: 1, 2, 3 N get {depths} mm in; with hard: true the tool stays out" in wall.reason
    )
    assert "softly" not in table.reason
    for one in (table, wall):
        assert f"the passivity layer ({scene.stability.passivity}) will take force to hold it" in one.reason
    felt = scene.mapping.force_scale * 0.5
    passive = (PRESETS["normal"].damping - felt * 1.0) / (0.0005 + 0.010 + 1e-3 * lag) / felt
    assert table.bounds == {"colgate_brown_with_hand": pytest.approx(passive, rel=1e-6)}
    assert table.frequency > 0.0
    assert f"it would swing at {table.frequency:.3g} Hz, {table.worst}" in table.reason
    assert table.worst.startswith("pressing along z ")


def test_lag_of_the_followers_servo_is_that_of_a_ramp():
    """x'' = w^2 (goal - x) - 2 zeta w x' follows a ramp 2 zeta / w late; without a servo there is no lag."""
    o = _core.SimulationOptions()
    o.follower.bandwidth, o.follower.damping_ratio = 25.0, 0.8
    assert _servo_lag(o) == pytest.approx(2.0 * 0.8 / (2.0 * np.pi * 25.0))
    o.follower.bandwidth = 0.0
    assert _servo_lag(o) == 0.0
