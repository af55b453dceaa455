"""Drivers by the vendors' libraries: they compile against the vendors' declarations, and only against those.

The headers in `hdapi`, `dhd` and `hdal` declare what the drivers use, as the vendors' documentation types it. A driver
that does not fit one of these signatures must not compile; the libraries beside the headers are stand-ins to run on.
"""

from __future__ import annotations

import re
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
from palpate.devices.open import open_python_driver
from palpate.session import Session

HERE, DEVICES = Path(__file__).parent, Path(palpate.__file__).parent / "devices"
DRIVERS = {
    "openhaptics.c": "hdapi/HD/hd.h",
    "force_dimension.cpp": "dhd/dhdc.h",
    "novint.cpp": "hdal/hdl/hdl.h",
}
CXX = shutil.which("c++") or shutil.which("g++")
pytestmark = pytest.mark.skipif(CXX is None or shutil.which("cc") is None, reason="no C and C++ compiler")
PROTOTYPE = re.compile(r"^([\w* ]+?[ *])(\w+)\(([^()]*)\);", re.M)


def compiled(driver, header, *more):
    """Compile a driver with the header's folder; the compiler's words, empty if it agrees."""
    cc, standard = ("cc", "-std=c11") if driver.endswith(".c") else (CXX, "-std=c++17")
    flags = [cc, standard, "-D_GNU_SOURCE", "-Wall", "-Wextra", "-Werror", "-fPIC", "-I", header, "-I", header_folder()]
    done = subprocess.run([*flags, *more, DEVICES / driver], capture_output=True, text=True, check=False)
    return done.stderr


def prototypes(name):
    return PROTOTYPE.findall((HERE / name).read_text())


@pytest.mark.parametrize("driver", DRIVERS)
def test_the_driver_compiles_against_the_vendors_declarations(driver):
    assert compiled(driver, HERE / DRIVERS[driver].partition("/")[0], "-fsyntax-only") == ""
    assert len(prototypes(DRIVERS[driver])) > 10


ALL = [(driver, name) for driver, header in DRIVERS.items() for _, name, _ in prototypes(header)]


@pytest.mark.parametrize(("driver", "name"), ALL, ids=[name for _, name in ALL])
def test_another_signature_of_a_function_is_found(driver, name, tmp_path):
    """One parameter more, as a vendor's next version may have it: each declared function is used, with its types."""
    header = DRIVERS[driver]
    text = (HERE / header).read_text()
    (result, parameters), *more = [(r, p) for r, n, p in prototypes(header) if n == name]
    assert not more
    first = "" if parameters in ("", "void") else f", {parameters}"
    changed = text.replace(f"{result}{name}({parameters});", f"{result}{name}(struct other* extra{first});")
    assert changed != text
    file = tmp_path / Path(header).relative_to(header.partition("/")[0])
    file.parent.mkdir(exist_ok=True)
    file.write_text("struct other;\n" + changed)
    assert name in compiled(driver, tmp_path, "-fsyntax-only")


@pytest.mark.parametrize(
    ("driver", "function", "old", "new"),
    [("openhaptics.c", "hdSetDoublev", "const HDdouble* values", "const float* values"),
     ("force_dimension.cpp", "dhdGetPositionAndOrientationFrame", "double matrix[3][3]", "float matrix[3][3]"),
     ("novint.cpp", "hdlToolButtons", "int* pButton", "bool* pButton")],
)  # fmt: skip
def test_a_parameter_of_another_type_is_found(driver, function, old, new, tmp_path):
    header = DRIVERS[driver]
    line = next(f"{r}{n}({p});" for r, n, p in prototypes(header) if n == function)
    file = tmp_path / Path(header).relative_to(header.partition("/")[0])
    file.parent.mkdir(exist_ok=True)
    file.write_text((HERE / header).read_text().replace(line, line.replace(old, new)))
    assert function in compiled(driver, tmp_path, "-fsyntax-only")


@pytest.fixture(scope="module", params=["force_dimension.cpp", "novint.cpp"])
def library(request, tmp_path_factory):
    """A driver in C++, linked with the stand-in of its vendor's library."""
    driver, folder = request.param, tmp_path_factory.mktemp("vendor")
    here = HERE / DRIVERS[driver].partition("/")[0]
    source = next(here.glob("*.cpp"))
    made = folder / driver.replace(".cpp", ".so")
    assert compiled(driver, here, "-shared", source, "-o", made, "-lpthread") == ""
    return made


AXIS = {"force_dimension.so": 2, "novint.so": 1}
"""The axis of the base that points up."""


def pressed(library, argument=""):
    base = {"xyz": [0, 0, 0], "rpy_deg": [90, 0, 0] if library.name == "novint.so" else [0, 0, 0]}
    leader = {"driver": f"{library}:{argument}" if argument else str(library), "base": base}
    made = palpate.Scene.model_validate({**scene().model_dump(mode="json"), "arms": {"leader": leader}})
    return Session(made.with_origin("", {}, trust=True))


def test_force_arrives_in_the_axes_of_the_vendor_and_ends_at_zero(library, tmp_path, monkeypatch):
    for name in ("DHD_LOG", "HDL_LOG"):
        monkeypatch.setenv(name, str(tmp_path / "log"))
    session = pressed(library)
    summary = session.run(1.2)
    del session  # closes the device
    forces, up = np.loadtxt(tmp_path / "log", ndmin=2), AXIS[library.name]
    assert 1.0 < forces[:, up].max() <= CAP * (1 + 1e-6)
    assert np.abs(np.delete(forces, up, axis=1)).max() < 1e-3
    assert not forces[-1].any()
    assert forces[:, up].max() <= summary.peak_force_N + 1e-4


def test_a_failing_device_ends_the_session_at_zero(library, tmp_path, monkeypatch):
    for name in ("DHD_LOG", "HDL_LOG"):
        monkeypatch.setenv(name, str(tmp_path / "log"))
    for name in ("DHD_FAIL", "HDL_FAIL"):
        monkeypatch.setenv(name, "1")
    session = pressed(library)
    summary = session.run(8.0)
    assert session.failed
    assert any("reported a failure" in fault for fault in summary.faults)
    assert not np.loadtxt(tmp_path / "log", ndmin=2)[-1].any()


def test_no_force_is_left_by_a_thread_that_was_stopped_while_it_held_the_lock(tmp_path):
    (tmp_path / "held.c").write_text("""
#include <stdio.h>
#include "servo.h"
int main(void) {
  palpate_servo s = {.lock = PTHREAD_MUTEX_INITIALIZER};
  const palpate_driver_state state = {.gripper = 0.5};
  const double wrench[6] = {1.0, 2.0, 3.0, 0.0, 0.0, 0.0};
  double F[3] = {0.0, 0.0, 0.0};
  palpate_servo_write(&s, wrench);
  const int first = palpate_servo_exchange(&s, &state, F);
  printf("%d %g ", first, F[2]);
  pthread_mutex_lock(&s.lock);
  nanosleep(&(struct timespec){0, 25000000}, NULL);
  const int taken = palpate_servo_exchange(&s, &state, F);
  printf("%d %g", taken, F[2]);
}
""")
    flags = ["-std=c11", "-D_GNU_SOURCE", "-Wall", "-Wextra", "-Werror", "-I", DEVICES, "-I", header_folder()]
    subprocess.run(["cc", *flags, tmp_path / "held.c", "-o", tmp_path / "held", "-lpthread"], check=True)
    done = subprocess.run([tmp_path / "held"], capture_output=True, text=True, check=True)
    assert done.stdout == "1 3 1 0"


READ = {"force_dimension.so": [("7", 0xC04, 0.3), ("3", 0xC04, 0.0)], "novint.so": [("", 0xA04, 0.0)]}
"""Argument, and the buttons and the gripper that the stand-in presses: coagulation, and what closes the jaws."""


def test_buttons_and_gripper_follow_the_table(library):
    for argument, buttons, gripper in READ[library.name]:
        driver = open_python_driver(f"{library}:{argument}", Path())
        driver.open()
        time.sleep(0.05)
        reading = driver.read()
        driver.close()
        assert reading.buttons == buttons
        assert reading.gripper == pytest.approx(gripper)
        assert driver.moment_max == 0.0, "no motor turns this handle"


def test_a_device_that_does_not_open_is_told(library):
    absent = {"force_dimension.so": ("12", "check power, cable and udev rules: no device found"),
              "novint.so": ("absent", "HDAL finds no Falcon of this name")}  # fmt: skip
    argument, words = absent[library.name]
    with pytest.raises(DeviceError, match=words):
        pressed(library, argument)
    if library.name == "force_dimension.so":
        for serial in ("7abc", "-7", "70000000000"):
            with pytest.raises(DeviceError, match=f"{serial} is no serial number"):
                pressed(library, serial)
    else:
        with pytest.raises(DeviceError, match="not calibrated: pull its grip out"):
            pressed(library, "new")
