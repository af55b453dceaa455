"""PyKDL in the environment of `make setup`: the system's module by a link, nothing else of the system."""

import importlib.machinery
import subprocess
import sys

import pytest

from palpate.ros import pykdl

SUFFIX = importlib.machinery.EXTENSION_SUFFIXES[0]


@pytest.fixture
def absent(monkeypatch):
    """PyKDL is not installed."""
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)


def folders(tmp_path, *names):
    system, into = tmp_path / "system", tmp_path / "environment"
    system.mkdir()
    into.mkdir()
    for name in names:
        (system / name).write_text("")
    return (system,), into


def test_module_of_this_python_is_linked_alone(tmp_path, absent):
    system, into = folders(tmp_path, f"PyKDL{SUFFIX}", "other.py")
    assert "a link to" in pykdl.link(system, into)
    assert [file.name for file in into.iterdir()] == [f"PyKDL{SUFFIX}"]
    assert (into / f"PyKDL{SUFFIX}").resolve() == system[0] / f"PyKDL{SUFFIX}"


def test_module_of_another_python_is_told_and_left(tmp_path, absent):
    system, into = folders(tmp_path, "PyKDL.cpython-27-x86_64-linux-gnu.so")
    assert "is for another Python" in pykdl.link(system, into)
    assert not list(into.iterdir())


def test_absent_module_is_told_with_the_command_that_installs_it(tmp_path, absent):
    system, into = folders(tmp_path)
    assert "sudo apt install python3-pykdl" in pykdl.link(system, into)


def test_link_to_a_removed_package_is_replaced(tmp_path, absent):
    system, into = folders(tmp_path, f"PyKDL{SUFFIX}")
    (into / f"PyKDL{SUFFIX}").symlink_to(tmp_path / "removed.so")
    pykdl.link(system, into)
    assert (into / f"PyKDL{SUFFIX}").exists()


def test_it_computes_with_poses_in_this_environment():
    """Where the system has the package, the environment of these tests reaches it after `palpate ros setup`."""
    words = pykdl.link()
    if "not installed" in words or "another Python" in words:
        pytest.skip(words)
    code = "import PyKDL; print(PyKDL.Frame(PyKDL.Rotation.RotZ(0.5), PyKDL.Vector(1, 2, 3)).Inverse().p)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    numbers = [float(x) for x in done.stdout.strip("[] \n").split(",")]
    assert numbers == pytest.approx([-1.8364, -1.2757, -3.0], abs=1e-3)
