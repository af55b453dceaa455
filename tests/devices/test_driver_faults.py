"""Each kind of wrong driver in one table: zero force within 20 ms of the first wrong value, by name of the cause."""

import re

import drivers
import numpy as np
import pytest
from test_driven import run

from palpate.devices import Reading


class Wrong(drivers.Failing):
    """Right at first; then `given` makes the reading. Keeps the force that follows each reading."""

    at = 0.5

    def __init__(self, given, where="read"):
        super().__init__()
        self.given, self.where, self.felt, self.first = given, where, [], None

    def read(self):
        X = self.pose()
        self.felt.append(None)
        if self.wrong() and self.where == "read":
            self.first = len(self.felt) - 1 if self.first is None else self.first
            return self.given(X)
        return X

    def write(self, wrench):
        if self.wrong() and self.where == "write" and wrench.any():
            self.first = len(self.felt) - 1 if self.first is None else self.first
            self.given(wrench)
        if self.felt:
            self.felt[-1] = float(np.linalg.norm(wrench))
        super().write(wrench)

    def close(self):
        super().close()
        if self.where == "close":
            self.given(None)


def fail(error):
    def given(X):
        raise error

    return given


def scaled(X):
    X = X.copy()
    X[:3, :3] *= 1000.0
    return X


def moved(X, factor):
    X = X.copy()
    X[:3, 3] = factor * X[:3, 3] - 0.001
    return X


V = np.zeros(6)
TABLE = {
    "raises in read": (lambda: Wrong(fail(OSError("cable"))), r"read\(\) raised OSError: cable"),
    "raises without words": (lambda: Wrong(fail(ValueError())), r"read\(\) raised ValueError"),
    "calls sys.exit": (lambda: Wrong(fail(SystemExit(3))), r"read\(\) raised SystemExit: 3"),
    "raises KeyboardInterrupt": (lambda: Wrong(fail(KeyboardInterrupt())), r"read\(\) raised KeyboardInterrupt"),
    "raises in write": (lambda: Wrong(fail(OSError("bus")), "write"), r"write\(\) raised OSError: bus"),
    "returns None": (lambda: Wrong(lambda X: None), r"read\(\) returned NoneType"),
    "returns text": (lambda: Wrong(lambda X: "pose"), r"read\(\) returned str"),
    "returns a position": (lambda: Wrong(lambda X: X[:3, 3]), r"returned ndarray of shape \(3,\)"),
    "returns uneven rows": (lambda: Wrong(lambda X: [[1.0], [1.0, 2.0]]), r"read\(\) returned list"),
    "returns complex numbers": (lambda: Wrong(lambda X: X.astype(complex) * 1j), "no rigid motion"),
    "returns words": (lambda: Wrong(lambda X: [["a"] * 4] * 4), "could not convert string to float"),
    "velocity of three": (lambda: Wrong(lambda X: Reading(X, np.zeros(3))), "V must have shape|incompatible|shape"),
    "gripper None": (lambda: Wrong(lambda X: Reading(X, V, None)), "NoneType"),
    "buttons in words": (lambda: Wrong(lambda X: Reading(X, V, 0.0, "left")), "left"),
    "NaN": (lambda: Wrong(lambda X: X * np.nan), "not finite"),
    "infinite velocity": (lambda: Wrong(lambda X: Reading(X, V + np.inf)), "not finite"),
    "NaN of the gripper": (lambda: Wrong(lambda X: Reading(X, V, np.nan)), "not finite"),
    "millimetres": (lambda: Wrong(lambda X: moved(X, 1000.0)), r"farther away .* \(millimetres\?\)"),
    "nanometres": (lambda: Wrong(lambda X: moved(X, 1e9)), "not finite"),
    "another place": (lambda: Wrong(lambda X: moved(X, -1.0)), "jumped"),
    "scaled rotation": (lambda: Wrong(scaled), "no rigid motion"),
    "transposed": (lambda: Wrong(lambda X: np.ascontiguousarray(X.T)), "no rigid motion"),
    "zeros": (lambda: Wrong(np.zeros_like), "no rigid motion"),
    "mirrored": (lambda: Wrong(lambda X: X @ np.diag([-1.0, 1, 1, 1])), "left-handed"),
}


@pytest.mark.parametrize("kind", TABLE)
def test_force_is_zero_within_20_ms_by_name_of_the_cause(kind):
    """20 ms are 10 readings of 500 Hz: counted, so that a busy machine does not matter."""
    make, words = TABLE[kind]
    driver = make()
    summary = run(driver, 0.8)
    before = [f for f in driver.felt[: driver.first] if f is not None]
    after = driver.felt[driver.first :]
    assert max(before) > 1.0, "it worked at first"
    lasting = 40 if "jumped" in words else None  # one jump: the force returns by a ramp 0.1 s later
    assert not any(f for f in after[10:lasting]), after
    assert lasting or driver.forces()[-1] == 0.0
    assert any(re.search(words, fault) for fault in summary.faults), summary.faults
    assert driver.closed


def test_a_driver_that_fails_while_it_is_closed_is_told_and_had_zero_force_before():
    driver = Wrong(fail(OSError("still in use")), "close")
    summary = run(driver, 0.5)
    assert driver.forces()[-1] == 0.0
    assert any(re.search(r"close\(\) raised OSError: still in use", fault) for fault in summary.faults)
