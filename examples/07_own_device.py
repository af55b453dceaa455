"""Your own haptic device: a driver of twenty lines, and the same device in a loop of your own.

The vendor's library is a stand-in here: it speaks millimetres, has its own axes, and lets a simulated hand press down.
Replace `Vendor` by the library of your device. You learn

* what a driver is: open, read, write, close, and the facts of the device in SI units;
* that palpate.Haptics does the same in a loop that is already yours;
* that the base of the device in the scene (arms.leader.base) turns its axes into those of the world.

    python examples/07_own_device.py --duration 3
"""

import time

import numpy as np
import tyro

import palpate
from palpate.devices import Driver


class Vendor:
    """A pretended library of an Omega: x towards the user, y right, z up, in millimetres."""

    def __init__(self) -> None:
        self.begin, self.p, self.force = time.monotonic(), np.zeros(3), np.zeros(3)

    def get_position(self) -> np.ndarray:
        """A soft hand of 300 N/m moves down by 40 mm within a second; the force pushes it back."""
        down = 40.0 * min(1.0, time.monotonic() - self.begin)
        self.p += 0.02 * (np.array([0.0, 0.0, -down]) + 1e3 * self.force / 300.0 - self.p)
        return self.p

    def set_force(self, force: np.ndarray) -> None:
        self.force = np.array(force)


class Omega(Driver):
    """The driver. Palpate calls read and write in turn, 1000 times a second, in a thread of its own."""

    rate = 1000.0  # Hz
    force_max = 12.0  # N; the scene's cap of 3 N is lower and wins
    workspace = (0.16, 0.16, 0.11)  # m

    def open(self) -> None:
        self.device = Vendor()

    def read(self) -> np.ndarray:
        X = np.eye(4)  # no rotation
        X[:3, 3] = 1e-3 * self.device.get_position()
        return X

    def write(self, wrench: np.ndarray) -> None:
        self.device.set_force(wrench[:3])

    def close(self) -> None:
        self.device.set_force(np.zeros(3))


# The device stands in front of the user, who looks along the world's y axis: its x axis is -y, its y axis is x.
SCENE = palpate.Scene.model_validate(
    {
        "objects": [{"name": "cushion", "sphere": {"radius": 0.03}, "stiffness": 400.0, "damping": 2.0}],
        "arms": {"leader": {"base": {"xyz": [0.2, 0.0, 0.0], "rpy_deg": [0, 0, -90]}}},
        "mapping": {"scale": 0.8},
    }
)


def own_loop(duration: float) -> None:
    """The same device in a loop of your own."""
    device, strongest, end = Vendor(), 0.0, time.monotonic() + duration
    with palpate.Haptics(SCENE, rate=500.0) as haptics:
        while (now := time.monotonic()) < end:
            X = np.eye(4)
            X[:3, 3] = 1e-3 * device.get_position()
            wrench = haptics.step(now, X)
            device.set_force(wrench[:3])
            strongest = max(strongest, float(np.linalg.norm(wrench[:3])))
            time.sleep(0.002)
        device.set_force(np.zeros(3))
        print(f"own loop: at most {strongest:.2f} N; now: {haptics.why()}")


def main(duration: float = 3.0) -> None:
    """Feel the cushion by the driver, then by a loop."""
    summary = palpate.Session(SCENE, driver=Omega()).run(duration)
    print(f"driver: at most {summary.peak_force_N:.2f} N, {summary.contact_s:.1f} s in contact")
    print(f"driver: {summary.scheduler}")
    own_loop(duration)


if __name__ == "__main__":
    tyro.cli(main)
