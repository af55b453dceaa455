"""Drivers for tests: a device at rest inside a surface, and each kind of wrong driver."""

import threading
import time

import numpy as np

from palpate.devices import Reading


class Still:
    """Moves 30 mm down within its first 150 readings, then rests; keeps every wrench with its time."""

    rate, force_max, workspace = 500.0, 5.0, (0.1, 0.1, 0.1)

    def __init__(self):
        self.written = []
        self.closed = False

    def open(self):
        self.count = 0

    def age(self):
        """Time since the first reading, by the number of readings [s]."""
        return self.count / self.rate

    def pose(self):
        self.count += 1
        X = np.eye(4)
        X[2, 3] = -0.03 * min(1.0, self.count / 150)
        return X

    def read(self):
        return self.pose()

    def write(self, wrench):
        self.written.append((time.monotonic(), wrench))

    def close(self):
        self.closed = True

    def forces(self):
        return np.array([np.linalg.norm(F) for _, F in self.written])


class Failing(Still):
    """Wrong from `at` [s] on."""

    at = 0.6

    def wrong(self):
        return self.age() > self.at


class Throws(Failing):
    def read(self):
        if self.wrong():
            raise OSError("cable pulled")
        return self.pose()


class ThrowsInWrite(Failing):
    broken = False

    def write(self, wrench):
        super().write(wrench)
        if self.wrong() and not self.broken:
            self.broken = True
            raise RuntimeError("bus off")


class Hangs(Failing):
    """Does not return from read until released."""

    def __init__(self):
        super().__init__()
        self.released = threading.Event()

    def read(self):
        if self.wrong():
            self.released.wait(30.0)
        return self.pose()


class Pauses(Failing):
    """Does not return from read for 60 ms, once."""

    paused = False

    def read(self):
        if self.wrong() and not self.paused:
            self.paused = True
            self.began = time.monotonic()
            time.sleep(0.06)
        return self.pose()


class ReturnsNaN(Failing):
    def read(self):
        X = self.pose()
        return np.full((4, 4), np.nan) if self.wrong() else X


class ReturnsMirror(Failing):
    def read(self):
        X = self.pose()
        return Reading(X @ np.diag([-1.0, 1, 1, 1])) if self.wrong() else Reading(X)


class ReturnsNothing(Failing):
    def read(self):
        return None if self.wrong() else self.pose()


class ReturnsShort(Failing):
    def read(self):
        return self.pose()[:3] if self.wrong() else self.pose()


class ReturnsWords(Failing):
    def read(self):
        return Reading([["a"] * 4] * 4) if self.wrong() else self.pose()


class Jumps(Failing):
    def read(self):
        X = self.pose()
        X[0, 3] = 0.5 * (len(self.written) % 2) * self.wrong()
        return X


class NoForceMax:
    rate = 500.0

    def open(self): ...
    def read(self): ...
    def write(self, wrench): ...
    def close(self): ...


class NoClose:
    rate, force_max = 500.0, 1.0

    def open(self): ...
    def read(self): ...
    def write(self, wrench): ...


class CannotOpen(Still):
    def open(self):
        raise PermissionError("/dev/omega")


class CannotBeMade:
    def __init__(self):
        raise RuntimeError("no licence")
