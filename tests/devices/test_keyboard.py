"""The keyboard by a pseudo-terminal and by a stream of events in a pipe."""

import contextlib
import os
import pty
import struct
import termios
import time

import numpy as np
import pytest
from test_driven import run

from palpate.base.errors import DeviceError
from palpate.devices.evdev import OPENING
from palpate.devices.keyboard import FINE, SPEED, STEP, Keyboard


@pytest.fixture
def terminal(monkeypatch):
    """A pseudo-terminal as the standard input, in whose foreground this process runs; its other end."""
    main, end = pty.openpty()
    monkeypatch.setattr("sys.stdin", os.fdopen(end, "r", closefd=False))
    monkeypatch.setattr("os.tcgetpgrp", lambda fd: os.getpgrp())
    yield main
    for fd in (main, end):
        with contextlib.suppress(OSError):
            os.close(fd)


def settled(keyboard):
    """The position once the handle has arrived."""
    for _ in range(100):
        p = keyboard.read().X[:3, 3]
        time.sleep(0.001)
        if np.array_equal(keyboard.read().X[:3, 3], p):
            break
    return p


KEYS = [
    (b"d", [STEP, 0, 0]), (b"a", [-STEP, 0, 0]), (b"w", [0, STEP, 0]), (b"s", [0, -STEP, 0]), (b"e", [0, 0, STEP]),
    (b"q", [0, 0, -STEP]), (b"D", [FINE, 0, 0]), (b"\x1b[C", [STEP, 0, 0]), (b"\x1b[D", [-STEP, 0, 0]),
    (b"\x1b[A", [0, STEP, 0]), (b"\x1b[B", [0, -STEP, 0]), (b"\x1b[5~", [0, 0, STEP]), (b"\x1b[6~", [0, 0, -STEP]),
    (b"ddW", [2 * STEP, FINE, 0]),
]  # fmt: skip


@pytest.mark.parametrize(("text", "moved"), KEYS)
def test_keys_of_the_terminal_move_the_handle(terminal, text, moved):
    keyboard = Keyboard()
    keyboard.open()
    os.write(terminal, text)
    time.sleep(0.002)
    assert settled(keyboard) == pytest.approx(moved)
    keyboard.close()


def test_the_terminal_is_given_back_as_it_was(terminal):
    before = termios.tcgetattr(terminal)
    keyboard = Keyboard()
    keyboard.open()
    assert termios.tcgetattr(terminal)[3] & termios.ICANON == 0
    assert termios.tcgetattr(terminal)[3] & termios.ISIG, "Ctrl-C still ends the run"
    keyboard.close()
    keyboard.close()
    assert termios.tcgetattr(terminal) == before


def test_space_and_c_switch_gripper_and_clutch(terminal):
    keyboard = Keyboard()
    keyboard.open()
    states = []
    for key in (b" ", b"c", b" ", b"c"):
        os.write(terminal, key)
        time.sleep(0.002)
        states.append(keyboard.read()[2:])
    assert states == [(0.0, 0), (0.0, 1), (OPENING, 1), (OPENING, 0)]
    keyboard.close()


@pytest.mark.parametrize(
    "junk", [b"\x00\xff\x1b\x1b", b"\x1b[99;5H", b"\xc3\xa9zz\n\t", bytes(range(256)) * 3, b"\x1b" * 50]
)
def test_other_keys_and_noise_are_ignored(terminal, junk):
    keyboard = Keyboard()
    keyboard.open()
    known = bytes(b for b in junk if b not in b"adwseqcADWSEQC \x03\x04\x11\x13\x1a\x1c")
    os.write(terminal, known[:1] + known[1:].replace(b"[", b"") + b"~~~")
    time.sleep(0.002)
    assert not settled(keyboard).any()
    os.write(terminal, b"d")
    time.sleep(0.002)
    assert settled(keyboard) == pytest.approx([STEP, 0, 0])
    keyboard.close()


def test_a_sequence_may_arrive_in_parts(terminal):
    keyboard = Keyboard()
    keyboard.open()
    for part in (b"\x1b", b"[", b"6", b"~"):
        os.write(terminal, part)
        time.sleep(0.002)
        keyboard.read()
    assert settled(keyboard) == pytest.approx([0, 0, -STEP])
    keyboard.close()


def test_a_flood_of_keys_neither_leaves_the_workspace_nor_moves_fast(terminal):
    keyboard, begin, last = Keyboard(), time.monotonic(), np.zeros(3)
    keyboard.open()
    os.write(terminal, b"d" * 3000)
    for _ in range(50):
        p = keyboard.read().X[:3, 3].copy()
        assert np.linalg.norm(p) <= SPEED * (time.monotonic() - begin) + 1e-9
        assert p[0] >= last[0]
        last = p
        time.sleep(0.001)
    keyboard._p = keyboard._target.copy()
    assert keyboard.read().X[0, 3] == pytest.approx(0.5 * Keyboard.workspace[0])
    keyboard.close()


def test_without_a_terminal_the_mend_is_told(monkeypatch, tmp_path):
    with open(os.devnull) as nothing:
        monkeypatch.setattr("sys.stdin", nothing)
        assert Keyboard.missing() == "the standard input is no terminal"
        with pytest.raises(DeviceError, match=r"no terminal[\s\S]*keyboard:/dev/input/eventN"):
            Keyboard().open()
    with pytest.raises(DeviceError, match="cannot be opened"):
        Keyboard(str(tmp_path / "none")).open()


def test_a_background_program_does_not_touch_the_terminal(terminal, monkeypatch):
    monkeypatch.setattr("os.tcgetpgrp", lambda fd: os.getpgrp() + 1)
    with pytest.raises(DeviceError, match="foreground"):
        Keyboard().open()


def test_a_closed_terminal_ends_the_session_by_name(terminal):
    class Closed(Keyboard):
        count = 0

        def read(self):
            self.count += 1
            if self.count == 50:
                os.close(terminal)
            return super().read()

    summary = run(Closed(), 1.0)
    assert any("read() raised OSError" in fault for fault in summary.faults)


def test_keys_touch_the_surface_in_a_session(terminal):
    class Pressed(Keyboard):
        count = 0

        def read(self):
            self.count += 1
            if self.count == 20:
                os.write(terminal, b"q" * 16)
            return super().read()

    summary = run(Pressed(), 0.8)
    assert summary.contact_s > 0.2
    assert 0.5 < summary.peak_force_N <= 3.0


def test_file_of_events(tmp_path):
    path = tmp_path / "event"
    os.mkfifo(path)
    reader = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    writer = os.open(path, os.O_WRONLY)
    keyboard = Keyboard(str(path))
    keyboard.open()
    rows = [
        (1, 106, 1),
        (1, 106, 2),
        (1, 106, 0),
        (0, 0, 0),
        (1, 57, 1),
        (1, 57, 2),
        (1, 46, 1),
        (1, 999, 1),
        (2, 0, 5),
    ]
    for row in rows:
        os.write(writer, struct.pack("llHHi", 0, 0, *row))
    assert settled(keyboard) == pytest.approx([2 * STEP, 0, 0])
    assert keyboard.read()[2:] == (0.0, 1)
    keyboard.close()
    os.close(writer)
    os.close(reader)
