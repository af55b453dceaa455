"""The driver of Force Dimension devices, with a stand-in that has the functions of forcedimension-core 1.0.0."""

import math
import sys
import types

import numpy as np
import pytest
from test_driven import run
from test_haptics import scene

from palpate.base.errors import DeviceError
from palpate.devices.driven import driven_scene
from palpate.devices.driver import facts
from palpate.devices.force_dimension import ForceDimension


class StandIn(types.ModuleType):
    """`forcedimension_core.dhd`: a device that moves 30 mm down within 150 readings."""

    def __init__(self, wrist=True, opens=True, turns=False):
        super().__init__("forcedimension_core.dhd")
        self.turns = turns
        self.wrist, self.opens, self.count, self.calls, self.broken = wrist, opens, 0, [], False

    def open(self) -> int:
        return 0 if self.opens else -1

    def errorGetLastStr(self) -> str:
        return "no device found" if not self.opens else "connection lost"

    def hasWrist(self, ID: int = -1) -> bool:
        return self.wrist

    def hasActiveWrist(self, ID: int = -1) -> bool:
        return self.turns

    def hasGripper(self, ID: int = -1) -> bool:
        return self.wrist

    def setGravityCompensation(self, enable: bool, ID: int = -1) -> int:
        return 0

    def enableForce(self, enable: bool, ID: int = -1) -> int:
        self.calls.append(("enableForce", enable))
        return 0

    def getPosition(self, out, ID: int = -1) -> int:
        self.count += 1
        out[0], out[1], out[2] = 0.0, 0.0, -0.03 * min(1.0, self.count / 150)
        return -1 if self.broken and self.count > 250 else 1  # 1: DHD_TIMEGUARD

    def getPositionAndOrientationFrame(self, p_out, matrix_out, ID: int = -1) -> int:
        c, s = math.cos(0.3), math.sin(0.3)
        for i, row in enumerate(((c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0))):
            for j in range(3):
                matrix_out[i][j] = row[j]
        return self.getPosition(p_out, ID)

    def getGripperAngleRad(self, out, ID: int = -1) -> int:
        out.value = 0.4
        return 0

    def getButton(self, index: int, ID: int = -1) -> int:
        return 0

    def setForceAndTorque(self, f, t, ID: int = -1) -> int:
        self.calls.append(("force", float(np.linalg.norm(f))))
        self.calls.append(("moment", float(np.linalg.norm(t))))
        return 0

    def close(self, ID: int = -1) -> int:
        self.calls.append(("close", ID))
        return 0


@pytest.fixture
def standing_in(monkeypatch):
    def put(**options):
        made = StandIn(**options)
        monkeypatch.setitem(sys.modules, "forcedimension_core", types.ModuleType("forcedimension_core"))
        monkeypatch.setitem(sys.modules, "forcedimension_core.dhd", made)
        return made

    return put


@pytest.mark.parametrize("wrist", [True, False], ids=["omega.7", "omega.3"])
def test_device_feels_the_surface_and_is_closed_at_zero_force(standing_in, wrist):
    dhd = standing_in(wrist=wrist)
    summary = run(ForceDimension(), 0.6)
    forces = [value for name, value in dhd.calls if name == "force"]
    assert max(forces) > 1.0
    assert max(forces) == pytest.approx(summary.peak_force_N)
    assert forces[-1] == 0.0
    assert next(call for call in dhd.calls if call[0] != "close") == ("enableForce", True)
    assert dhd.calls[-2:] == [("enableForce", False), ("close", 0)]


def test_lost_connection_ends_with_zero_force_and_the_words_of_the_vendor(standing_in):
    dhd = standing_in(wrist=False)
    dhd.broken = True
    summary = run(ForceDimension(), 5.0)
    assert any("connection lost" in fault for fault in summary.faults)
    assert [value for name, value in dhd.calls if name == "force"][-1] == 0.0


def test_absent_device_and_absent_binding_are_told(standing_in, monkeypatch):
    standing_in(opens=False)
    with pytest.raises(DeviceError, match="no device found"):
        ForceDimension().open()
    monkeypatch.setitem(sys.modules, "forcedimension_core.dhd", None)
    with pytest.raises(DeviceError, match="pip install forcedimension-core"):
        ForceDimension().open()


@pytest.mark.parametrize("turns", [True, False], ids=["sigma.7", "omega.7"])
def test_only_a_wrist_with_motors_is_given_a_moment(standing_in, turns):
    dhd = standing_in(turns=turns)
    driver = ForceDimension()
    given = scene().model_copy(update={"stability": scene().stability.model_copy(update={"moment_cap": 1.0})})
    made = driven_scene(given, facts(driver, "force-dimension"))
    assert made.stability.moment_cap == (0.1 if turns else 0.0)
    assert dhd.calls == [("close", 0)], "it was asked without a force, and closed"


@pytest.mark.parametrize("serial", ["7abc", "²", "-3", "7.0", "12345678901"])
def test_what_is_no_serial_number_is_refused(serial):
    with pytest.raises(DeviceError, match="is no serial number"):
        ForceDimension(serial)
