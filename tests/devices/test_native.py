"""Drivers in C: the force they get, and zero force by name of the cause for each kind of wrong driver."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_driven import with_driver
from test_haptics import CAP

from palpate.base.errors import DeviceError
from palpate.devices import loop
from palpate.devices.driver import facts
from palpate.devices.handle import AtHandle
from palpate.devices.native import header_folder
from palpate.devices.shared_object import SharedObject
from palpate.session import Session

SOURCE = Path(__file__).with_name("c_driver.c")
CC = shutil.which("cc") or shutil.which("gcc")
pytestmark = pytest.mark.skipif(CC is None, reason="no C compiler")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    out = tmp_path_factory.mktemp("driver") / "c_driver.so"
    flags = ["-std=c11", "-D_POSIX_C_SOURCE=200809L", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run([CC, *flags, "-I", header_folder(), SOURCE, "-o", out, "-lm"], check=True)
    return out


def run(library, fault, tmp_path, seconds=1.0):
    """Summary, and the number of the reading and the force [N] of each wrench that was written, (n, 2)."""
    log = tmp_path / "written"
    session = Session(with_driver(f"{library}:{fault},{log}"))
    summary = session.run(seconds)
    return session, summary, np.loadtxt(log)


def test_good_driver_feels_the_surface_and_ends_with_zero_force(library, tmp_path):
    session, summary, written = run(library, "none", tmp_path)
    assert 1.0 < written[:, 1].max() <= CAP * (1 + 1e-6)
    assert written[:, 1].max() == pytest.approx(summary.peak_force_N)
    assert written[-1, 1] == 0.0
    assert not session.failed
    assert "lateness" in summary.scheduler


def test_what_a_driver_states_of_its_handle_reaches_the_passivity_layer(library, tmp_path, monkeypatch):
    seen, port = [], loop.device_port
    monkeypatch.setattr(loop, "device_port", lambda scene, known: seen.append(known) or port(scene, known))
    for name in ("handle", "none"):
        Session(with_driver(f"{library}:{name},{tmp_path / 'log'}"))
    assert seen == [AtHandle(5e-6, 0.3, 1e-3, 0.08, 0.6), AtHandle()]
    known = facts(SharedObject(library, f"handle,{tmp_path / 'log'}"), "handle")
    assert known.at_handle == seen[0]
    with pytest.raises(DeviceError, match="only with its resolution"):
        Session(with_driver(f"{library}:handle without resolution,{tmp_path / 'log'}"))


@pytest.mark.parametrize(("fault", "words"), [("fail", r"read() reported"), ("write", "write() reported")])
def test_reported_failure_ends_the_session_with_zero_force(library, tmp_path, fault, words):
    session, summary, written = run(library, fault, tmp_path, 5.0)
    assert written[:, 1].max() > 1.0
    assert written[-1, 1] == 0.0
    assert session.failed
    assert summary.duration_s < 2.0
    assert any(words in f and "the force was set to zero" in f for f in summary.faults)


@pytest.mark.parametrize("fault", ["nan", "mirror", "empty"])
def test_nonsense_gives_zero_force_by_name(library, tmp_path, fault):
    _, summary, written = run(library, fault, tmp_path)
    assert written[:, 1].max() > 1.0
    assert not written[written[:, 0] > 300, 1].any()
    assert any("not finite" in f for f in summary.faults)


def test_pause_gets_zero_force_from_the_watchdog(library, tmp_path):
    session, summary, written = run(library, "pause", tmp_path)
    during = written[written[:, 0] == 301, 1]
    assert len(during) >= 2, "the watchdog wrote, and the loop after the pause"
    assert not during.any()
    assert session.timing["stalls"] >= 1
    assert any("silent" in f for f in summary.faults)


def test_hanging_driver_gets_zero_force_and_the_process_ends(library, tmp_path):
    """In a process of its own, as the thread stays behind."""
    text = (
        "import sys; sys.path[:0] = sys.argv[1:3]\n"
        "from test_native import run\nfrom pathlib import Path\n"
        "_, summary, written = run(sys.argv[3], 'hang', Path(sys.argv[4]), 8.0)\n"
        "assert written[:, 1].max() > 1.0 and written[-1, 1] == 0.0\n"
        "assert any('read() did not return within 1 s' in f for f in summary.faults), summary.faults\n"
        "print('zero force')\n"
    )
    here = Path(__file__).parent
    done = subprocess.run(
        [sys.executable, "-c", text, here, here.parents[1], library, tmp_path],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    assert "zero force" in done.stdout


@pytest.mark.parametrize(
    ("argument", "words"),
    [("refuse", "no licence on this machine"), ("old", "compiled for version 0"), ("rate", "must be 50 to 10000 Hz")],
)
def test_driver_that_cannot_be_used_is_refused(library, argument, words):
    with pytest.raises(DeviceError, match=words):
        Session(with_driver(f"{library}:{argument}"))


def test_files_that_are_no_drivers_are_refused(tmp_path):
    (tmp_path / "empty.so").write_bytes(b"")
    with pytest.raises(DeviceError, match=r"driver\.h there says"):
        Session(with_driver(f"{tmp_path / 'empty.so'}"))
    (tmp_path / "one.c").write_text("int one(void) { return 1; }\n")
    subprocess.run([CC, "-shared", "-fPIC", tmp_path / "one.c", "-o", tmp_path / "one.so"], check=True)
    with pytest.raises(DeviceError, match="no function palpate_driver_open"):
        Session(with_driver(f"{tmp_path / 'one.so'}"))
