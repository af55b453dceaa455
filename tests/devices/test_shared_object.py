"""`palpate device test` and `bench` of a driver in C: its facts, its readings, the direction of a push, its mass."""

import json
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from palpate.base.errors import DeviceError
from palpate.cli import main
from palpate.devices.driver import facts
from palpate.devices.native import header_folder
from palpate.devices.shared_object import SharedObject
from palpate.devices.trace import rounds

CC = shutil.which("cc") or shutil.which("gcc")
pytestmark = pytest.mark.skipif(CC is None, reason="no C compiler")


@pytest.fixture(scope="module")
def mass(tmp_path_factory):
    out = tmp_path_factory.mktemp("mass") / "c_mass.so"
    flags = ["-std=c11", "-D_POSIX_C_SOURCE=200809L", "-Wall", "-Wextra", "-Werror", "-O1", "-shared", "-fPIC"]
    source = Path(__file__).with_name("c_mass.c")
    subprocess.run([CC, *flags, "-I", header_folder(), source, "-o", out, "-lm"], check=True)
    return out


def test_a_driver_in_c_passes_the_test(mass, tmp_path, capsys):
    assert main(["device", "test", str(mass), "--yes", "--json", str(tmp_path / "a.json")]) == 0, capsys.readouterr()
    names = {check["name"] for check in json.loads((tmp_path / "a.json").read_text())["checks"]}
    assert {"open", "finite", "rigid"} <= names


def test_a_force_in_the_wrong_direction_is_found(mass, capsys):
    assert main(["device", "test", f"{mass}:wrong", "--yes"]) == 1
    assert "FAIL" in capsys.readouterr().out


def test_it_moves_as_the_closed_form_of_its_mass(mass):
    """A constant force on a mass m with damping b: x = F / b (t - m / b (1 - exp(-b t / m)))."""
    m, b, F = 0.3, 2.0, 0.5
    driver = SharedObject(mass)
    before = time.monotonic()
    driver.write(np.array([F, 0.0, -F, 0.0, 0.0, 0.0]))
    after = time.monotonic()
    for _ in range(5):
        time.sleep(0.03)
        begin, X, end = time.monotonic(), np.asarray(driver.read().X), time.monotonic()
        low, high = (F / b * (t - m / b * (1.0 - np.exp(-b * t / m))) for t in (begin - after, end - before))
        assert low - 1e-4 <= X[0, 3] <= high + 1e-4
        assert X[2, 3] == -X[0, 3]
        assert X[1, 3] == 0.0
    driver.close()


def test_it_can_be_benched(mass, tmp_path, capsys):
    out = tmp_path / "model.yaml"
    args = ["device", "bench", str(mass), "--yes", "--json", str(tmp_path / "b.json"), "--out", str(out)]
    assert main(args) == 0, capsys.readouterr()
    assert [axis["axis"] for axis in json.loads((tmp_path / "b.json").read_text())["axes"]] == ["x", "y", "z"]
    assert out.is_file()  # the values depend on how busy the machine is: test_bench.py judges them in lockstep


def test_a_closed_device_is_refused_until_it_is_opened_again(mass):
    driver = SharedObject(mass)
    driver.close()
    for use in (driver.read, lambda: driver.write(np.zeros(6))):
        with pytest.raises(RuntimeError, match="its device is closed"):
            use()
    driver.close()
    driver.open()
    assert np.asarray(driver.read().X)[:3, 3] == pytest.approx(np.zeros(3))
    driver.open()
    driver.close()


def test_a_pose_that_is_not_filled_in_is_not_a_number(mass):
    """Zeros would be a place: a push would go on without a measurement."""
    driver = SharedObject(mass, "empty")
    assert np.isnan(driver.read().X).all()
    known = facts(driver, "empty")
    assert rounds(driver, known, 0.1, lambda t, moved: np.ones(3)).stopped


@pytest.mark.parametrize(
    ("argument", "words"), [("refuse", "the cable is out"), ("old", "has version 0 of the interface, not 1")]
)
def test_a_driver_that_cannot_be_used_is_named(mass, argument, words):
    with pytest.raises(DeviceError, match=words):
        SharedObject(mass, argument)


def test_a_file_that_is_no_driver_is_named(tmp_path, capsys):
    (tmp_path / "a.so").write_bytes(b"no library")
    assert main(["device", "test", str(tmp_path / "a.so"), "--yes"]) == 2
    words = capsys.readouterr().err
    assert "a.so cannot be used" in words
    assert "compile it with -shared" in words
