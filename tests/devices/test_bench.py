"""The bench recovers the parameters of simulated devices, and the test finds each kind of wrong driver."""

import json
import re
from dataclasses import replace
from itertools import count

import numpy as np
import pytest
import yaml
from drivers import Still

import palpate
from palpate.base.errors import DeviceError, RecordingError
from palpate.cli import main
from palpate.devices import Driver, Reading, bench
from palpate.devices.bench import measure
from palpate.devices.identify import fit_axis, noise, resolution
from palpate.devices.judge import judge_driver
from palpate.devices.published import attributes_of
from palpate.devices.simulated import SimulatedDevice, Truth

LIGHT = Truth(mass=0.08, damping=0.2, friction=0.03, noise=0.0, resolution=3e-5, delay=0)
MIDDLE = Truth(noise=3e-5, resolution=1e-5)
HEAVY = Truth(mass=0.6, damping=2.0, friction=0.15, noise=2e-5, resolution=0.0, delay=5)


def errors(bench, truth):
    """What of the bench differs from the truth by more than its stated tolerance."""
    wrong = []

    def compare(name, found, true, relative, absolute=0.0):
        if abs(found - true) > relative * true + absolute:
            wrong.append(f"{name}: {found:.4g}, not {true:.4g}")

    for axis in bench.axes:
        compare("mass", axis.fit.mass, truth.mass, 0.03)
        compare("damping", axis.fit.damping, truth.damping, 0.15, 0.05)
        compare("friction", axis.fit.friction, truth.friction, 0.1, 0.005)
        compare("delay", axis.fit.delay, truth.delay * 1e-3, 0.0, 2e-4)  # a fifth of a period
        compare("stiffness", axis.fit.stiffness, truth.stiffness, 0.02, 0.7)
        compare("resolution", axis.resolution_m or 0.0, truth.resolution, 1e-3)
        compare("noise", axis.noise_m, truth.noise, 0.1, 1e-7)
    return wrong


@pytest.fixture(scope="module", params=[LIGHT, MIDDLE, HEAVY], ids=["light", "middle", "heavy"])
def benched(request):
    return measure(SimulatedDevice(truth=request.param), "simulated"), request.param


def test_bench_recovers_a_known_device(benched):
    bench, truth = benched
    assert errors(bench, truth) == []
    assert not bench.stopped


def test_wrong_truth_would_be_noticed(benched):
    """The comparison fails for each parameter that is off by enough, and for one period of delay."""
    bench, truth = benched
    for name in ("mass", "damping", "friction", "noise", "resolution"):
        if getattr(truth, name) > 0.0:
            factor = {"damping": 2.0, "friction": 1.5}.get(name, 1.2)
            assert any(name in e for e in errors(bench, replace(truth, **{name: factor * getattr(truth, name)}))), name
    assert any("delay" in e for e in errors(bench, replace(truth, delay=truth.delay + 1)))


def test_model_file_is_what_certify_reads(benched, tmp_path):
    bench, truth = benched
    bench.model().save(tmp_path / "device.yaml", {"device": "simulated"})
    model = palpate.DeviceModel.load(tmp_path / "device.yaml")
    assert model.mass == pytest.approx(truth.mass, rel=0.03)
    assert model.quantum == pytest.approx(truth.resolution, rel=1e-3)
    # the unsafe end of the intervals
    assert -2e-5 < model.delay - 1e-3 * truth.delay < 4e-4
    assert model.damping <= 1.01 * truth.damping
    assert model.friction <= 1.01 * truth.friction


def test_limit_of_a_wall_is_stated_at_the_unsafe_end(benched):
    bench, truth = benched
    known = palpate.DeviceModel(
        mass=truth.mass, damping=truth.damping, rate=bench.rate_Hz, delay=1e-3 * truth.delay,
        quantum=truth.resolution, friction=truth.friction,
    )  # fmt: skip
    limit, unsafe = bench.limits()
    true = palpate.certify(known).k_max
    assert unsafe <= true * 1.01
    assert limit == pytest.approx(true, rel=0.15)


@pytest.mark.parametrize(
    "truth",
    [
        Truth(noise=0.0, delay=2.5, stiffness=40.0),
        Truth(noise=0.0, delay=0.75, mass=0.4, stiffness=150.0, damping=1.0),
        Truth(noise=0.0, delay=28),
        Truth(noise=0.0, delay=45, mass=0.35, friction=0.1),
    ],
    ids=["spring", "stiff spring", "28 ms", "45 ms"],
)
def test_parts_of_a_period_springs_and_long_delays_are_found(truth):
    bench = measure(SimulatedDevice(truth=truth), "simulated")
    assert errors(bench, truth) == []
    assert any("restoring force" in text for text in bench.doubts()) == (truth.stiffness > 0.0)


def test_delay_beyond_the_search_is_refused():
    with pytest.raises(DeviceError, match="later than 60 ms"):
        measure(SimulatedDevice(truth=Truth(delay=85)), "late")


class Jointed(SimulatedDevice):
    """Encoders in joints: two turning links and a slide."""

    step = 2e-4  # rad; the links are 0.15 m long
    link = 0.15

    def read(self):
        x, y, z = np.asarray(super().read().X)[:3, 3] + [0.2, 0.05, 0.0]
        bend = 2.0 * np.arccos(np.hypot(x, y) / (2.0 * self.link))
        turn = np.arctan2(y, x) - 0.5 * bend
        bend, turn = (self.step * np.round(q / self.step) for q in (bend, turn))
        z = 0.15 * self.step * np.round(z / (0.15 * self.step))
        X = np.eye(4)
        X[:3, 3] = [
            self.link * (np.cos(turn) + np.cos(turn + bend)) - 0.2,
            self.link * (np.sin(turn) + np.sin(turn + bend)) - 0.05,
            z,
        ]
        return Reading(X)


def test_steps_of_encoders_in_joints_are_seen():
    class Exact(Jointed):
        step = 1e-9

    truth = Truth(noise=0.0, resolution=0.0)
    seen, exact = measure(Jointed(truth=truth), "jointed"), measure(Exact(truth=truth), "exact")
    for axis, other, scale in zip(seen.axes, exact.axes, (0.14, 0.2, 0.15), strict=True):
        assert axis.uneven == (axis.axis != "z")  # the slide's steps lie on a grid
        assert axis.resolution_m == pytest.approx(scale * Jointed.step, rel=0.5)
        assert other.resolution_m is None or other.resolution_m < 1e-7
        assert axis.fit.mass == pytest.approx(truth.mass, rel=0.05)


class Cogging(SimulatedDevice):
    """Motors whose force depends on the place."""

    def _advance(self, F, dt, steps):
        for _ in range(steps):
            super()._advance(F + 0.15 * np.sin(self._p / 1.5e-3), dt, 1)


def test_device_of_another_form_is_told():
    assert len([text for text in measure(Cogging(), "cogging").doubts() if "another form" in text]) == 3
    assert measure(SimulatedDevice(), "plain").doubts() == ()


def test_intervals_of_an_axis_hold_the_truth():
    inside = []
    for seed in range(8):
        truth = Truth(seed=seed, noise=2e-5, delay=2.25)
        for axis in measure(SimulatedDevice(truth=truth), "simulated").axes:
            for name, true in [("mass", truth.mass), ("damping", truth.damping), ("friction", truth.friction),
                               ("delay", 2.25e-3)]:  # fmt: skip
                reach = axis.fit.student * getattr(axis.fit.deviations, name)
                inside.append(abs(getattr(axis.fit, name) - true) < reach)
    assert np.mean(inside) > 0.87  # 96 of 0.95


def test_the_attributes_for_a_driver_claim_no_more_friction_than_there_is():
    """Over 8 devices, with noise below and above the step; the resolution covers both."""
    excess = []
    for seed in range(8):
        truth = Truth(seed=seed, noise=(1e-6, 2e-5)[seed % 2], delay=2.25)
        found = attributes_of(measure(SimulatedDevice(truth=truth), "simulated"))
        excess += [found[name] / getattr(truth, name) for name in ("friction", "damping") if name in found]
        assert found["resolution"] >= 0.9 * max(truth.resolution, 6 * truth.noise)
        assert found["mass"] == pytest.approx(truth.mass, rel=0.05)
        assert found["delay"] > 2.2e-3
    assert len(excess) >= 14, "control: they are stated"
    assert np.mean(np.array(excess) <= 1.0) >= 0.9
    assert max(excess) < 1.05


def test_noise_of_the_position_does_not_make_a_device_lighter():
    """Noise of 0.1 mm: plain least squares takes it for motion, and finds a mass 4 to 5 % too small."""
    found = []
    for seed in range(3):
        truth = Truth(seed=seed, noise=1e-4, delay=2.25)
        found += [axis.fit.mass / truth.mass for axis in measure(SimulatedDevice(truth=truth), "noisy").axes]
    assert abs(np.mean(found) - 1.0) < 0.02, found


def test_resolution_and_noise_of_known_signals():
    rng = np.random.default_rng(3)
    x = 0.01 * np.sin(np.linspace(0, 9, 4000)) + 1e-5 * rng.standard_normal(4000)
    assert resolution(x) == 0.0
    for step in (1e-6, 3.7e-5):
        assert resolution(0.123 + step * np.round(x / step)) == pytest.approx(step, rel=1e-4)
    t = np.arange(4000) * 1e-3
    assert noise(t, 0.01 * t + 2e-5 * rng.standard_normal(4000), 0.0) == pytest.approx(2e-5, rel=0.05)


def test_nothing_is_fitted_to_a_device_that_does_not_move():
    t = np.arange(2000) * 1e-3
    assert fit_axis(t, np.zeros(2000), np.sin(30 * t)) is None


def test_device_that_hardly_moves_has_no_model():
    bench = measure(SimulatedDevice(truth=Truth(friction=0.6)), "stuck")
    assert all(axis.fit is None for axis in bench.axes)
    with pytest.raises(DeviceError, match="did not move"):
        bench.model()


class Broken(SimulatedDevice):
    """A simulated device with one fault."""

    def __init__(self, change=None, force=None):
        super().__init__(truth=Truth(noise=1e-6, resolution=0.0))
        self.lockstep, self.change, self.force = True, change, force

    def read(self):
        X = np.asarray(super().read().X)
        return Reading(self.change(X)) if self.change else Reading(X)

    def write(self, wrench):
        super().write(self.force(wrench) if self.force else wrench)


def exchanged(wrench):
    return wrench[[1, 0, 2, 3, 4, 5]]


def drifting():
    """A handle that moves by 2 um in each reading."""
    n, along_x = count(), np.outer([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 2e-6])
    return Broken(lambda X: X + along_x * next(n))


FAULTS = {
    "rest": drifting(),
    "finite": Broken(lambda X: X + np.nan),
    "rigid": Broken(lambda X: np.vstack([np.hstack([np.eye(3), np.zeros((3, 1))]), [[0.1, 0, 0, 1]]])),
    "right-handed": Broken(lambda X: X @ np.diag([1.0, -1, 1, 1])),
    "metres": Broken(lambda X: X + np.array([[0, 0, 0, 50.0], [0] * 4, [0] * 4, [0] * 4])),
    "push y": Broken(force=lambda w: w * [1, -1, 1, 0, 0, 0]),
    "push x": Broken(force=exchanged),
    "push z": Broken(force=lambda w: w * [1, 1, 0, 0, 0, 0]),
}


@pytest.mark.parametrize(("name", "driver"), FAULTS.items())
def test_each_kind_of_wrong_driver_fails_by_name(name, driver):
    failed = [check for check in judge_driver(driver, "broken", push=True) if not check.passed]
    assert name in [check.name for check in failed]
    assert all(check.mend for check in failed)


def test_good_driver_passes_all_checks():
    checks = judge_driver(Broken(), "good", push=True)
    assert [check.name for check in checks if not check.passed] == []
    assert [check.name for check in checks][-3:] == ["push x", "push y", "push z"]


def test_slow_and_failing_drivers_are_named():
    class Slow(Still):
        def read(self):
            drivers_time.sleep(0.004)
            return np.eye(4)

    import time as drivers_time

    failed = [c.name for c in judge_driver(Slow(), "slow", push=False) if not c.passed]
    assert failed == ["rate"]

    class Dead(Driver):
        force_max = 1.0

        def open(self):
            raise OSError("no such device")

    (check,) = judge_driver(Dead(), "dead", push=False)
    assert (check.name, check.passed) == ("open", False)
    assert "no such device" in check.value


def test_a_device_that_moves_against_its_force_is_refused():
    """Its model had the least mass that there is, and a servo would have driven it away from its goal."""
    reversed_z = Broken(force=lambda w: w * [1, 1, -1, 0, 0, 0])
    with pytest.raises(DeviceError, match="reversed moves against the force along z"):
        measure(reversed_z, "reversed")


def test_a_handle_that_moves_without_a_force_is_not_pushed():
    """The hand of a stand-in, for example: axes were called wrong, and the bench ended in a traceback."""
    names = [check.name for check in judge_driver(drifting(), "moving", push=True)]
    assert names[-1] == "rest"
    with pytest.raises(DeviceError, match=r"moved by 2 mm .* without a force"):
        measure(drifting(), "moving")


def test_motion_that_does_not_come_from_the_force_is_refused(monkeypatch):
    t = np.arange(3000) / 1000
    x = 0.02 * np.sin(4 * np.pi * t)
    monkeypatch.setattr(bench, "fit_axis", lambda *_: fit_axis(t, x, np.zeros(3000), 0.1, 1e-5))
    with pytest.raises(DeviceError, match="do not tell mass, friction and delay apart"):
        measure(SimulatedDevice(), "other")


def test_a_machine_that_is_too_busy_for_the_pushes_is_named(monkeypatch):
    """The bench said that the device was not pushed, or hardly moved."""
    real = bench._push

    def busy(*words):
        trace = real(*words)
        return replace(trace, t=trace.t + 0.02 * (np.arange(len(trace.t)) // 20))

    found = measure(SimulatedDevice(), "quiet")
    assert replace(found, rate_Hz=1000.0, interval_p99_us=4167.0).irregular
    assert not replace(found, rate_Hz=1000.0, interval_p99_us=1200.0).irregular
    monkeypatch.setattr(bench, "_push", busy)
    monkeypatch.setattr(bench, "fit_axis", lambda *_: None)
    with pytest.raises(DeviceError, match="ms apart during the pushes"):
        measure(SimulatedDevice(), "busy")


def test_no_push_exceeds_what_the_driver_allows():
    class Weak(SimulatedDevice):
        force_max, most = 0.2, 0.0

        def write(self, wrench):
            self.most = max(self.most, float(np.abs(wrench).max()))
            super().write(wrench)

    driver = Weak()
    judge_driver(driver, "weak", push=True)
    assert driver.most == pytest.approx(0.2)


@pytest.mark.parametrize("call", ["read", "write"])
def test_a_cable_pulled_during_the_bench_is_named_and_the_device_closed(call):
    class Pulled(Still):
        force_max, rounds, closed = 1.0, 0, False

        def _count(self, name):
            self.rounds += name == call
            if self.rounds > 20:
                raise OSError("no such device")

        def read(self):
            self._count("read")
            return np.eye(4)

        def write(self, wrench):
            self._count("write")

        def close(self):
            self.closed = True

    driver = Pulled()
    with pytest.raises(DeviceError, match=rf"{call}\(\) raised OSError: no such device"):
        measure(driver, "pulled")
    assert driver.closed


def test_commands(tmp_path, capsys):
    out, figures, page = tmp_path / "device.yaml", tmp_path / "bench.json", tmp_path / "device.html"
    command = ["device", "bench", "simulated", "--yes", "--out", str(out), "--json", str(figures)]
    assert main([*command, "--weight", "0.1", "--page", str(page)]) == 0
    found = json.loads(figures.read_text())
    keys = {"name", "rate_Hz", "interval_p99_us", "fresh", "axes", "stopped", "model", "force", "stated", "attributes"}
    assert keys | {"like", "published", "checks"} == set(found)
    assert found["like"] is None
    assert all(check["passed"] for check in found["checks"])
    model = yaml.safe_load(out.read_text())
    assert model["kind"] == "device"
    assert model["notes"]["driver"] == found["attributes"]
    assert set(found["attributes"]) <= {"resolution", "mass", "delay", "friction", "damping"}
    assert found["force"][0]["gain"] == pytest.approx(1.0, abs=0.01)
    stated = {row["name"]: row for row in found["stated"]}
    assert stated["resolution"]["measured"] == pytest.approx(10.0, rel=1e-3)
    assert stated["mass"]["measured"] == pytest.approx(stated["mass"]["stated"], rel=0.03)
    assert {"Force", "As stated?", "Stable wall"} <= set(re.findall(r"<h2>([^<]+)</h2>", page.read_text()))
    assert main(["certify", str(out), "--stiffness", "200", "--damping", "1", "--json", str(figures)]) == 0
    assert json.loads(figures.read_text())["verdict"] == "stable"
    assert main(["device", "list", "--json", str(figures)]) == 0
    listed = json.loads(figures.read_text())
    assert "simulated" in [one["name"] for one in listed["drivers"]]
    assert main(["device", "test", "simulated", "--no-push", "--json", str(figures)]) == 0
    assert json.loads(figures.read_text())["passed"]


def test_nothing_is_pushed_without_consent(capsys):
    assert main(["device", "bench", "simulated"]) == 2
    assert "give --yes" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("mass: 1", "no line kind"),
        ("kind: device\nmass: heavy\ndamping: 1", "mass = 'heavy'"),
        ("kind: device\nmass: 0.2\ndamping: 1\nwidth: 2", "unknown key 'width'"),
        ("kind: device\nmass: 0.2", "damping"),
        ("kind: device\nmass: -1\ndamping: 1", "mass"),
    ],
)
def test_wrong_device_file_is_refused_with_the_cause(tmp_path, text, words):
    (tmp_path / "d.yaml").write_text(text)
    with pytest.raises((RecordingError, palpate.base.errors.PalpateError), match=words):
        palpate.DeviceModel.load(tmp_path / "d.yaml")


def test_force_between_samples_biases_nothing():
    """Exact motion of 0.2 kg with 0.5 N s/m and a delay of 2.4 periods: a sum of samples took 0.05 % off the mass."""
    m, b, part, dt = 0.2, 0.5, 0.4, 1e-3
    t = dt * np.arange(1800)
    F = 0.5 * np.sign(np.sin(2.0 * np.pi * t / 0.3 + 0.3))
    x, v, p, f = np.zeros(len(t)), 0.0, 0.0, np.r_[0.0, 0.0, 0.0, F]

    def moved(p, v, force, dt):
        free, decay = force / b, np.exp(-b / m * dt)
        return p + free * dt + (v - free) * m / b * (1.0 - decay), free + (v - free) * decay

    for k in range(len(t)):
        x[k] = p
        p, v = moved(p, v, f[k], part * dt)  # of three periods before, until the next force arrives
        p, v = moved(p, v, f[k + 1], (1.0 - part) * dt)
    found = fit_axis(t, x, F, 0.09)
    assert found.mass == pytest.approx(m, rel=1e-4)
    assert found.delay == pytest.approx(2.4 * dt, abs=1e-6)
    assert abs(found.stiffness) < 1e-3
