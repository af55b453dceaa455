"""Mouse and gamepad by a recorded stream of events in a pipe."""

import struct
import time

import numpy as np
import pytest
from test_driven import run

from palpate.base.errors import DeviceError
from palpate.devices.evdev import OPENING, Gamepad, Mouse, find

LISTED = """I: Bus=0003 Vendor=046d Product=c077 Version=0111
N: Name="Logitech USB Optical Mouse"
H: Handlers=mouse0 event5
B: EV=17

I: Bus=0003 Vendor=045e Product=028e Version=0110
N: Name="Microsoft X-Box 360 pad"
H: Handlers=event7 js0
"""


def events(*rows):
    return b"".join(struct.pack("llHHi", 1700000000, i, *row) for i, row in enumerate(rows))


def test_mouse_moves_by_its_counts(pipe):
    path, writer = pipe
    mouse = Mouse(path)
    mouse.open()
    assert np.array_equal(mouse.read().X, np.eye(4))
    writer.write(events((2, 0, 30), (2, 1, 20), (0, 0, 0), (2, 8, -3), (1, 0x110, 1), (1, 0x111, 1)))
    reading = mouse.read()
    assert reading.X[:3, 3] == pytest.approx([3e-3, -2e-3, -3e-3])
    assert (reading.gripper, reading.buttons) == (0.0, 1)
    writer.write(events((1, 0x110, 0), (1, 0x111, 0), (2, 0, 100000)))
    reading = mouse.read()
    assert (reading.gripper, reading.buttons) == (OPENING, 0)
    assert reading.X[0, 3] == pytest.approx(0.1), "the edge of the workspace"
    mouse.close()


def test_sticks_of_a_gamepad_set_the_velocity(pipe):
    path, writer = pipe
    pad = Gamepad(path)
    pad.open()
    writer.write(events((3, 0, 32767), (3, 1, 1000), (3, 4, 32767), (3, 5, 255), (1, 0x136, 1)))
    reading = pad.read()
    assert (reading.gripper, reading.buttons) == (0.0, 1)
    assert pad.velocity() == pytest.approx([0.05, 0.0, -0.05])
    before = pad.read().X[0, 3]
    time.sleep(0.02)
    assert 0.0009 < pad.read().X[0, 3] - before < 0.0026
    writer.write(events((3, 0, 0), (3, 4, 0)))
    rest = pad.read().X.copy()
    assert np.array_equal(pad.read().X, rest)
    pad.close()


def test_mouse_touches_the_surface_in_a_session(pipe):
    path, writer = pipe
    for _ in range(15):
        writer.write(events((2, 8, 0)))

    class Scripted(Mouse):
        count = 0

        def read(self):
            self.count += 1
            if 20 <= self.count < 36:
                writer.write(events((2, 8, -1)))  # 1 mm down with each reading
            return super().read()

    summary = run(Scripted(path), 0.6)
    assert summary.contact_s > 0.2
    assert 0.5 < summary.peak_force_N <= 3.0


def test_devices_are_found_and_their_absence_is_told(tmp_path):
    assert find("mouse", LISTED) == "/dev/input/event5"
    assert find("js", LISTED) == "/dev/input/event7"
    with pytest.raises(DeviceError, match="no gamepad is connected"):
        find("js", LISTED.partition("\n\n")[0])
    with pytest.raises(DeviceError, match="cannot be opened"):
        Mouse(str(tmp_path / "none")).open()
