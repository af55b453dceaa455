"""A virtual wall: effect of stiffness, damping and delay on a hand that pushes against the wall.

The experiment of the paper's Fig 13 and Table 1, on the simulated master arm: a flat wall of 400 N/m, three values of
damping, a light hand that intends to push with 0.7 N, once with and once without 10 ms of delay in the loop. You learn

* that a scene is a few lines of data, and that a session runs it tick by tick;
* that a delayed spring returns more energy than it absorbed, and that damping dissipates the excess.

    python examples/01_virtual_wall.py --duration 6 --figure wall.png
"""

import tempfile
import warnings
from pathlib import Path

import numpy as np
import trimesh
import tyro

import palpate

RATE, STIFFNESS, RADIUS = 500.0, 400.0, 0.002  # [Hz], [N/m], [m]
HAND = {"mass": 0.5, "damping": 0.6, "stiffness": 58.0}  # [kg], [N s/m], [N/m]
PUSH = 0.7  # [N]


def wall_scene(block: Path, damping: float, delay: float) -> palpate.Scene:
    """The top of a block, at z = 0, is the wall. The hand starts 15 mm above it and aims below it."""
    aim = -PUSH / STIFFNESS - PUSH / HAND["stiffness"]  # deflection of both springs [m]
    path = [{"t": 0.0, "xyz": [0.0, 0.0, 0.015 + RADIUS]}, {"t": 0.5, "xyz": [0.0, 0.0, aim + RADIUS]}]
    return palpate.Scene.model_validate(
        {
            "objects": [{"name": "wall", "mesh": str(block), "stiffness": STIFFNESS, "damping": damping}],
            "contact": {"radius": RADIUS},
            "rates": {"haptic": RATE},
            "mapping": {"scale": 1.0, "force_scale": 1.0},
            "operator": {**HAND, "path": path},
            "loop_delay": delay,
            # The paper had neither caps nor a passivity controller; "observer" instead of "off" keeps the port passive.
            "stability": {"force_cap": 20.0, "rate_cap": 5000.0, "passivity": "off"},
        }
    )


def response(depth: np.ndarray) -> tuple[float, float, float]:
    """Peak [mm], mean of the last second [mm], and time until the depth stays within 5 % of the peak around it [s]."""
    peak, last = depth.max(), depth[-int(RATE) :]
    outside = np.flatnonzero(np.abs(depth - last.mean()) > 0.05 * peak)
    touched = int(np.argmax(depth > 0))
    return 1e3 * peak, 1e3 * last.mean(), (int(outside[-1]) + 1 - touched) / RATE


def main(duration: float = 6.0, figure: Path | None = None) -> None:
    """Run six walls and print a table."""
    # Palpate warns that the first wall may oscillate, which is intended here.
    warnings.simplefilter("ignore", palpate.base.errors.PalpateWarning)
    block = Path(tempfile.mkdtemp()) / "block.stl"
    trimesh.creation.box(bounds=[(-60, -60, -40), (60, 60, 0)]).export(block)  # [mm]

    print(f"wall of {STIFFNESS:g} N/m at {RATE:g} Hz; {PUSH:g} N at rest is {1e3 * PUSH / STIFFNESS:.2f} mm deep")
    print("delay ms | B N s/m | peak mm | offshoot % of 0.385 m | at the end mm | settles in s | wall gave J")
    traces = {}
    for delay in (0.0, 0.010):
        for damping in (0.0, 5.0, 10.0):
            session = palpate.Session(wall_scene(block, damping, delay))
            ticks = [session.step().tick for _ in range(int(duration * RATE))]
            depth = np.array([float(tick["depth"]) for tick in ticks])
            peak, end, settled = response(depth)
            gave = max(0.0, -min(float(tick["energy_port"]) for tick in ticks))
            when = f"{settled:12.2f}" if settled < duration - 1.5 else "       never"
            row = f"{1e3 * delay:8.0f} | {damping:7g} | {peak:7.2f} | {peak / 3.85:21.2f} | {end:13.2f}"
            print(f"{row} | {when} | {gave:11.4f}")
            traces[f"{1e3 * delay:g} ms, {damping:g} N s/m"] = depth
    print("Table 1 of the paper read the same way: offshoot 10.2 / 1.27 / 1.25 %, settling in 0.4 / 0.5 / 0.5 s")

    if figure is not None:
        import matplotlib.pyplot as plt

        for name, depth in traces.items():
            plt.plot(np.arange(len(depth)) / RATE, 1e3 * depth, label=name)
        plt.xlabel("time [s]")
        plt.ylabel("depth in the wall [mm]")
        plt.legend(title="delay, damping")
        plt.savefig(figure, dpi=120)
        print(f"figure: {figure}")


if __name__ == "__main__":
    tyro.cli(main)
