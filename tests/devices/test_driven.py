"""Drivers in Python: the force they get, and zero force by name of the cause for each kind of wrong driver."""

import re
import sys
import threading
from pathlib import Path

import drivers
import numpy as np
import pytest
from test_haptics import CAP, scene

import palpate
from palpate.base.errors import DeviceError
from palpate.devices import open_driver
from palpate.record.reader import Record
from palpate.session import Session


def run(driver, seconds=0.9, **changes):
    session = Session(scene(**changes), driver=driver)
    return session.run(seconds)


def test_good_driver_feels_the_surface_and_ends_with_zero_force(tmp_path):
    driver = drivers.Still()
    session = Session(scene(rates={"haptic": 1000.0}), tmp_path, driver=driver)
    summary = session.run(0.7)
    assert 1.0 < driver.forces().max() <= CAP * (1 + 1e-6)
    assert driver.forces()[-1] == 0.0
    assert driver.closed
    assert sys.getswitchinterval() == pytest.approx(0.005), "restored"
    assert "lateness" in summary.scheduler
    assert session.rate == 500.0, "the rate of the driver, not of the scene"
    record = Record.open(summary.record)
    assert np.linalg.norm(record.ticks["F_H_L"], axis=1).max() == pytest.approx(driver.forces().max())


def test_cap_is_the_lower_one_of_scene_and_device():
    driver = drivers.Still()
    driver.force_max = 0.5
    assert run(driver, 0.5).peak_force_N == pytest.approx(0.5)


ENDS = [
    (drivers.Throws, r"read\(\) raised OSError: cable pulled"),
    (drivers.ThrowsInWrite, r"write\(\) raised RuntimeError: bus off"),
    (drivers.ReturnsNothing, r"read\(\) returned NoneType"),
    (drivers.ReturnsShort, r"read\(\) returned ndarray of shape \(3, 4\)"),
    (drivers.ReturnsWords, "could not convert string to float"),
    (drivers.Hangs, r"read\(\) did not return within 1 s"),
]


@pytest.mark.parametrize(("kind", "words"), ENDS, ids=lambda x: getattr(x, "__name__", ""))
def test_failing_driver_ends_the_session_with_zero_force_and_the_cause(kind, words):
    driver = kind()
    summary = run(driver, 5.0)
    assert driver.forces().max() > 1.0, "it worked at first"
    assert driver.forces()[-1] == 0.0
    (fault,) = [f for f in summary.faults if f.startswith("driver ")]
    assert re.search(words, fault)
    assert "the force was set to zero" in fault
    assert summary.duration_s < 2.5
    assert driver.closed
    getattr(driver, "released", threading.Event()).set()


STAYS = [
    (drivers.ReturnsNaN, "a number was not finite"),
    (drivers.ReturnsMirror, "a number was not finite"),
    (drivers.Jumps, "a pose jumped"),
]


@pytest.mark.parametrize(("kind", "words"), STAYS, ids=lambda x: getattr(x, "__name__", ""))
def test_nonsense_gives_zero_force_while_it_lasts_by_name(kind, words):
    driver = kind()
    summary = run(driver, 0.9)
    assert driver.forces().max() > 1.0
    assert not driver.forces()[-20:].any()
    assert any(words in fault for fault in summary.faults)


def test_stalled_call_gets_zero_force_from_another_thread_before_it_returns():
    driver = drivers.Pauses()
    session = Session(scene(), driver=driver)
    summary = session.run(1.3)
    during = [F for t, F in driver.written if driver.began < t < driver.began + 0.058]
    assert len(during) >= 1
    assert not during[-1].any()
    assert session.timing["stalls"] >= 1
    after = [np.linalg.norm(F) for t, F in driver.written if driver.began + 0.06 < t < driver.began + 0.12]
    assert not any(after), "the force returns only when all has been well for 0.1 s"
    assert driver.forces()[-40:].max() > 1.0
    assert any("silent" in fault for fault in summary.faults)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("drivers:NoForceMax", "force_max = None must be 0 to 100 N"),
        ("drivers:NoClose", r"has no function close"),
        ("drivers:Nobody", "has no attribute 'Nobody'"),
        ("nowhere_at_all:Device", "cannot be imported"),
        ("drivers:CannotBeMade", "RuntimeError: no licence"),
        ("loop", "driven by a loop of your own"),
    ],
)
def test_driver_that_cannot_be_used_is_refused_with_the_cause(name, words):
    with pytest.raises(DeviceError, match=words):
        Session(with_driver(name))


def test_device_that_cannot_be_opened_is_told():
    with pytest.raises(DeviceError, match=r"open\(\) raised PermissionError: /dev/omega"):
        run(drivers.CannotOpen())


def with_driver(name):
    made = scene()
    other = palpate.Scene.model_validate({**made.model_dump(mode="json"), "arms": {"leader": {"driver": name}}})
    return other.with_origin("", {}, trust=True)


def test_driver_is_looked_for_in_the_folder_of_the_scene(tmp_path):
    (tmp_path / "my_own_device.py").write_text(Path(drivers.__file__).read_text())
    made = with_driver("my_own_device:Still")
    (tmp_path / "my.yaml").write_text(made.to_yaml())
    summary = Session(palpate.Scene.load(tmp_path / "my.yaml", trust=True)).run(0.5)
    assert summary.peak_force_N > 1.0


@pytest.mark.parametrize("name", ["omega", "my device.py", "module", ""])
def test_scene_refuses_a_name_that_is_no_driver(name):
    with pytest.raises(ValueError, match="there is no driver"):
        with_driver(name)


def test_simulated_device_feels_the_surface():
    driver = open_driver("simulated")
    assert run(driver, 2.5).peak_force_N > 0.2
