"""The driver of OpenHaptics devices, compiled against a stand-in of the vendor's header and library."""

import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from test_haptics import CAP, scene

import palpate
from palpate.base.errors import DeviceError
from palpate.devices.native import header_folder
from palpate.session import Session

HERE = Path(__file__).parent
SHIM = Path(palpate.__file__).parent / "devices" / "openhaptics.c"
CC = shutil.which("cc") or shutil.which("gcc")
pytestmark = pytest.mark.skipif(CC is None, reason="no C compiler")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("openhaptics")
    flags = [CC, "-std=c11", "-D_GNU_SOURCE", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    include = ["-I", HERE / "hdapi", "-I", header_folder()]
    subprocess.run(
        [*flags, *include, HERE / "hdapi" / "hd.c", "-o", folder / "libHD.so", "-lm", "-lpthread"], check=True
    )
    link = ["-L", folder, "-lHD", f"-Wl,-rpath,{folder}", "-lpthread"]
    subprocess.run([*flags, *include, SHIM, "-o", folder / "openhaptics.so", *link], check=True)
    return folder / "openhaptics.so"


def touched(driver):
    """The device's y points up: its base is turned by 90 degrees about x."""
    leader = {"driver": str(driver), "base": {"xyz": [0, 0, 0], "rpy_deg": [90, 0, 0]}}
    made = palpate.Scene.model_validate({**scene().model_dump(mode="json"), "arms": {"leader": leader}})
    return made.with_origin("", {}, trust=True)


def test_force_arrives_in_the_axes_of_the_vendor_and_ends_at_zero(library, tmp_path, monkeypatch):
    monkeypatch.setenv("HD_LOG", str(tmp_path / "log"))
    monkeypatch.setenv("HD_GO", str(tmp_path / "go"))
    session = Session(touched(library))
    session.start()
    (tmp_path / "go").touch()
    time.sleep(1.0)
    summary = session.close()
    del session  # closes the device
    forces = np.loadtxt(tmp_path / "log", ndmin=2)
    assert 1.0 < forces[:, 1].max() <= CAP * (1 + 1e-6)
    assert np.abs(forces[:, [0, 2]]).max() < 1e-3
    assert forces[-1].any() == 0
    assert forces[:, 1].max() <= summary.peak_force_N + 1e-4


def test_failing_device_ends_the_session(library, tmp_path, monkeypatch):
    monkeypatch.setenv("HD_LOG", str(tmp_path / "log"))
    monkeypatch.setenv("HD_GO", str(tmp_path / "go"))
    monkeypatch.setenv("HD_FAIL", "1")
    session = Session(touched(library))
    session.start()
    (tmp_path / "go").touch()
    end = time.monotonic() + 10.0
    while not session.failed and time.monotonic() < end:
        time.sleep(0.01)
    assert session.failed
    summary = session.close()
    del session  # closes the device
    assert any("reported a failure" in fault for fault in summary.faults)
    forces = np.loadtxt(tmp_path / "log", ndmin=2)
    assert forces[:, 1].max() > 1.0
    assert not forces[-1].any(), "the driver sets zero last, whatever the library does with a callback that ends"


def test_absent_device_is_told(library):
    with pytest.raises(DeviceError, match="OpenHaptics finds no device absent"):
        Session(touched(f"{library}:absent"))
