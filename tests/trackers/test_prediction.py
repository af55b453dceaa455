"""Tracked organs are felt where they are now, not where a late and noisy tracker saw them.

The judge is a sinusoidal or stopped surface in closed form: the force that it would give at the recorded tool, and the
work of that force by this file's own quadrature. What was felt before prediction is computed from the same poses.
"""

import math

import numpy as np
import pytest

from palpate import Session, _core
from palpate.base.arrays import rigid
from palpate.scene import Scene
from palpate.sensing.trackers import Sighting
from palpate.sensing.trackers.clock import MeasurementClock
from palpate.sensing.trackers.prediction import Predictor
from palpate.sensing.trackers.tracking import Tracking

K, RADIUS, RATE, A, F = 300.0, 0.002, 1000.0, 0.010, 0.25
TOP = 0.02  # height of the block's top over its frame [m]
SCENE = """\
frames: [{{child: patient, tracker: t, pose: {{xyz: [0, 0, 0]}}}}]
trackers: {{t: {{simulated: {{}}, delay_ms: {delay_ms}}}}}
objects: [{{name: block, box: {{size: [0.4, 0.4, 0.04]}}, frame: patient, stiffness: 300, damping: 0, friction: 0}}]
stability: {{passivity: "off"}}
operator: {{path: {path}}}
"""
HELD = "[{t: 0, xyz: [0, 0, 0.05]}, {t: 1, xyz: [0, 0, -0.005]}, {t: 99, xyz: [0, 0, -0.005]}]"

# A hand that moves in phase with the breathing, 5 mm up and down.
IN_PHASE = (
    "["
    + ", ".join(
        f"{{t: {t}, xyz: [0, 0, {0.005 * math.sin(2 * math.pi * F * t) + 0.003 + 0.05 * max(0.0, 1.0 - t):.5f}]}}"
        for t in np.arange(0.0, 14.0, 0.25)
    )
    + "]"
)


def breathing(t):
    return A * np.sin(2 * np.pi * F * np.asarray(t))


def stop(t, at=4.0):
    """A rise at the fastest speed of breathing that ends at once."""
    return 2 * np.pi * F * A * (np.minimum(t, at) - at)


def rest(t):
    return np.zeros_like(np.asarray(t, float))


class Marker:
    """A tracker of the height z(t) of a marker [m], with rate [Hz], delay [s] and noise [m] and [rad] on each axis.

    stamp: what the tracker writes as the time of a measurement at t [s].
    """

    def __init__(self, z, rate=60.0, delay=0.03, noise=1.5e-4, stamp=lambda t: t, seed=0):
        self.z, self.rate, self.delay, self.noise, self.stamp = z, rate, delay, noise, stamp
        self.rng, self.k, self.hidden = np.random.default_rng(seed), 0, (math.inf, math.inf)
        self.poses = []  # (time of arrival, height as measured)

    def poll(self, now):
        found = []
        while self.k / self.rate + self.delay <= now:
            t, self.k = self.k / self.rate, self.k + 1
            noise = self.noise * self.rng.normal(size=6)
            if self.hidden[0] <= t < self.hidden[1]:
                continue
            X = np.eye(4)
            X[:3, :3] = rigid.exp(4.0 * noise[3:])
            X[:3, 3] = [*noise[:2], noise[2] + float(self.z(t))]
            self.poses.append((now, X[2, 3]))
            found.append(Sighting("patient", X, self.stamp(t)))
        return found

    def close(self): ...


def felt(marker, seconds, path=HELD, delay_ms=0.0):
    """Ticks of a session whose block follows the marker."""
    session = Session(Scene.parse(SCENE.format(path=path, delay_ms=delay_ms)))
    session.tracking = Tracking(session.rig, session.simulation, {"t": marker})
    return np.array([session.step().tick for _ in range(round(seconds * RATE))])


def true_force(ticks, z):
    """Force on the tool from the surface in closed form [N]: z(t) is the height of the block's frame [m]."""
    return K * np.maximum(z(ticks["t"]) + TOP + RADIUS - ticks["p_WT"][:, 2], 0.0)


def before(marker, t):
    """Height of the block as it followed this marker before prediction: the newest pose, without velocity."""
    X, heights, k = np.eye(4), [], -1
    X[2, 3] = marker.poses[0][1]
    one, limits = _core.Approach(X), _core.LiveOptions(p_OC=np.zeros(3))
    for now in t:
        while k + 1 < len(marker.poses) and marker.poses[k + 1][0] <= now:
            k += 1
        X[2, 3] = marker.poses[max(k, 0)][1]
        one.step(float(now), limits, X)
        heights.append(one.X_WO[2, 3])
    return np.array(heights)


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def follow(marker, seconds):
    """Height of the block at every tick, by the predictor, its clock and the loop's motion law alone, and the times."""
    X, clock, one, limits = np.eye(4), MeasurementClock(), None, _core.LiveOptions(p_OC=np.zeros(3))
    X[2, 3] = float(marker.z(0.0))
    block, V, t, z = _core.Approach(X), np.zeros(6), [], []
    for k in range(round(seconds * 100)):
        now = 0.01 * k
        for seen in marker.poll(now):
            measured = clock.time(seen.t, now, 1e9)
            if one is None:
                one = Predictor(seen.X, measured)
            one.take(seen.X, measured)
        if one is not None:
            X = one.at(now, clock.delay)
            V = rigid.displacement(one.at(now - 1e-3, clock.delay), X) / 1e-3 if one.moving else np.zeros(6)
        for j in range(1, 11):
            block.step(now + 1e-3 * j, limits, X, V, False, now)
            t.append(now + 1e-3 * j)
            z.append(block.X_WO[2, 3])
    return np.array(t), np.array(z)


@pytest.fixture(scope="module")
def breath():
    marker = Marker(breathing)
    return marker, felt(marker, 13.0, path=IN_PHASE)


def work(F, ticks, late):
    """Work of a force along z on the tool, by the trapezoidal rule [J]."""
    return float(np.trapezoid(F[late], ticks["p_WT"][late, 2]))


def test_a_breathing_organ_is_felt_where_it_is(breath):
    """Asked: 0.08 N rms of 300 N/m at 0.25 Hz, 10 mm; a 60 Hz tracker, 30 ms late, noise of 0.15 mm."""
    marker, ticks = breath
    late, F = ticks["t"] >= 5.0, true_force(ticks, breathing)
    assert F[late].min() > 0.3
    assert rms((ticks["F_T_W"][:, 2] - F)[late]) < 0.08
    assert K * rms((before(marker, ticks["t"]) - breathing(ticks["t"]))[late]) > 0.4, (
        "the judge finds the lag of before"
    )


def test_the_organ_does_the_work_that_a_true_organ_does(breath):
    """Over two periods of a hand that moves in phase, by own quadrature: the true spring does none.

    Before, the lag phi made it pi K A a sin(phi) a period, for a hand of amplitude a.
    """
    marker, ticks = breath
    late = (ticks["t"] > 5.0) & (ticks["t"] <= 13.0)
    z = before(marker, ticks["t"])
    lagging = K * (z + TOP + RADIUS - ticks["p_WT"][:, 2])
    true = work(true_force(ticks, breathing), ticks, late)
    assert abs(work(lagging, ticks, late) - true) > 10e-3
    assert abs(work(ticks["F_T_W"][:, 2], ticks, late) - true) < 2e-3


def test_the_velocity_that_contact_is_given_is_that_of_the_block(breath):
    """The rendered block moves by its velocity, so that the ledger credits the work of this motion and no other."""
    _, ticks = breath
    ticks = ticks[ticks["t"] > 2.0]
    z = ticks["live_p"][:, 2]
    force, moved = ticks["F_T_W"][1:, 2], np.diff(z)
    assert np.abs(moved).max() * RATE < 0.03
    fast = np.abs(moved[1:]) * RATE > 1e-3  # an object that comes to rest may lose its last mm/s at once
    assert np.abs(np.diff(moved))[fast].max() * RATE**2 < 0.51  # LiveOptions.acceleration
    expected = K * np.maximum(z[1:] + TOP + RADIUS - ticks["p_WT"][1:, 2], 0.0)
    assert force == pytest.approx(expected, abs=2e-3)


@pytest.mark.parametrize(
    ("rate", "delay", "noise"), [(20, 0.03, 1e-4), (30, 0.05, 1e-4), (60, 0.03, 1.5e-4), (60, 0.1, 1e-4)]
)
def test_trackers_of_many_kinds(rate, delay, noise):
    """Breathing within 0.08 N; a stop with a smaller error, at most and over a second; no motion at rest."""
    marker = Marker(breathing, rate, delay, noise)
    t, z = follow(marker, 10.0)
    assert K * rms((z - breathing(t))[t > 4.0]) < 0.08
    new, old = [], []
    for seed in range(5):
        marker = Marker(stop, rate, delay, noise, seed=seed)
        t, z = follow(marker, 5.0)
        new.append(K * (z - stop(t))[t > 4.0])
        old.append(K * (before(marker, t) - stop(t))[t > 4.0])
    assert np.abs(new).max() < 0.8 * np.abs(old).max()
    assert rms(new) < rms(old)
    marker = Marker(rest, rate, delay, noise)
    t, z = follow(marker, 5.0)
    assert np.ptp(z) == 0.0


@pytest.mark.parametrize("name", ["constant", "offset", "slow", "fast", "early"])
def test_wrong_stamps_are_safe(name):
    """No stamp makes the organ worse than before; those of an unknown constant offset cost the unknown delay alone."""
    stamps = {
        "constant": lambda t: 17.0 + 1e-9 * t,
        "offset": lambda t: t + 5000.0,
        "slow": lambda t: 0.5 * t,
        "fast": lambda t: 2.0 * t,
        "early": lambda t: t - 0.1,
    }
    marker = Marker(breathing, stamp=stamps[name])
    t, z = follow(marker, 12.0)
    error, old = z - breathing(t), before(marker, t) - breathing(t)
    assert rms(error[t > 6.0]) < (0.9 if name == "early" else 0.6) * rms(old[t > 6.0])
    assert np.abs(error).max() < 1.2 * np.abs(old).max()


def test_a_known_delay_of_a_foreign_clock_is_compensated():
    """Stamps of another clock with `delay_ms`: as good as stamps of this machine."""
    clock = MeasurementClock(0.03)
    times = [clock.time(k / 60 + 5000.0, math.ceil(100 * (k / 60 + 0.03)) / 100, 1e9) for k in range(200)]
    assert times[100:] == pytest.approx(np.arange(100, 200) / 60, abs=1e-3)


def test_a_hidden_marker_stops_the_organ_and_its_return_is_smooth():
    """Hidden at the fastest moment for 1 s: the block goes on by 2 mm at most, and comes back within its limits."""
    marker = Marker(breathing)
    marker.hidden = (4.0, 5.0)
    ticks = felt(marker, 8.0)
    t, z = ticks["t"], ticks["live_p"][:, 2]
    hidden = (t > 4.0) & (t < 5.0)
    assert z[hidden].max() - breathing(4.0) < 2e-3
    assert np.ptp(z[(t > 4.5) & (t < 5.0)]) < 1e-6
    assert np.abs(np.diff(z)).max() * RATE < 0.101
    fast = np.abs(np.diff(z))[1:] * RATE > 1e-3
    assert np.abs(np.diff(z, 2))[fast].max() * RATE**2 < 0.51
    assert rms((z - breathing(t))[t > 7.0]) < 0.08 / K


def test_a_tool_that_turns_is_predicted_too():
    """Rotation of 3 deg at 0.25 Hz about x, 50 ms late with noise of 0.5 mrad: within 1.3 mrad rms."""
    rng, one, error, late = np.random.default_rng(1), None, [], []
    angle = lambda t: math.radians(3.0) * math.sin(2 * np.pi * F * t)  # noqa: E731
    for k in range(600):
        t = k / 60
        X = rigid.rigid(rigid.exp(np.array([angle(t), 0, 0]) + rng.normal(scale=5e-4, size=3)), [0.1, 0.2, 0.3])
        if one is None:
            one = Predictor(X, t)
        one.take(X, t)
        seen = one.at(t + 0.05, 0.05)
        true = rigid.exp([angle(t + 0.05), 0, 0])
        error.append(np.linalg.norm(rigid.log(seen[:3, :3] @ true.T)))
        late.append(angle(t) - angle(t + 0.05))
        assert seen[:3, 3] == pytest.approx([0.1, 0.2, 0.3], abs=1e-12)
    assert rms(error[300:]) < 1.3e-3
    assert rms(late[300:]) > 2.5e-3
