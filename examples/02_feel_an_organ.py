"""Feel an organ: the complete loop from Python, and the results of a session.

A simulated hand holds a simulated master arm, which moves a simulated instrument over the shipped organ: approach,
press, slide, leave. You learn

* how to load a scene, run it, and print its summary in ten lines;
* how to read any signal of the run, here the force on the hand in each phase;
* how to change a setting of a session: the second run makes the organ half as stiff.

    python examples/02_feel_an_organ.py --duration 10 --out runs
"""

from pathlib import Path

import numpy as np
import tyro

import palpate
from palpate.record import Record

SCENE = Path(__file__).resolve().parents[1] / "scenes" / "palpation.yaml"


def show(name: str, summary: object) -> None:
    """Print a summary, a frozen dataclass whose field names contain the units."""
    print(f"\n{name}")
    for field in ("contact_s", "peak_force_N", "mean_force_N", "max_penetration_m", "energy_J", "cycle_p50_us"):
        print(f"  {field:<20} {getattr(summary, field):.4g}")


def main(duration: float = 10.0, out: Path = Path("runs"), figure: Path | None = None) -> None:
    """Feel the organ twice; print both runs and the phases of the first."""
    scene = palpate.Scene.load(SCENE)
    session = palpate.Session(scene, out=out, seed=1)

    phases: dict[str, list[float]] = {}  # force on the hand by phase [N]
    summary = session.run(duration, on_progress=lambda s: phases.setdefault(s.phase, []).append(s.force))
    show(f"as the scene says (record: {session.record})", summary)
    for phase, forces in phases.items():
        print(f"  {phase:<10} {np.mean(forces):5.2f} N on average, {np.max(forces):5.2f} N at most")

    softer = palpate.Session(scene, seed=1)
    controls = softer.controls
    controls.stiffness_scale = 0.5
    softer.controls = controls
    show("half as stiff", softer.run(duration))

    assert session.record is not None
    ticks = Record.open(session.record).ticks  # a structured numpy array: one row per tick, one field per signal
    force, depth = np.linalg.norm(ticks["F_H_L"], axis=1), 1e3 * ticks["depth"]
    touching = ticks["contacts"] > 0
    print(
        f"\n{len(ticks)} ticks, {touching.mean():.0%} in contact; a row holds {', '.join(ticks.dtype.names[:6])}, ..."
    )
    if touching.any():
        stiffness = np.median(force[touching] / np.maximum(depth[touching], 1e-6))
        print(
            f"force over depth, median: {stiffness:.3f} N/mm (the scene's stiffness, as far as the caps let it through)"
        )

    if figure is not None:
        import matplotlib.pyplot as plt

        axes = plt.subplots(2, sharex=True)[1]
        for axis, values, label in zip(axes, (force, depth), ("force on the hand [N]", "depth [mm]"), strict=True):
            axis.plot(ticks["t"], values)
            axis.set_ylabel(label)
        axes[-1].set_xlabel("time [s]")
        plt.savefig(figure, dpi=120)
        print(f"figure: {figure}")


if __name__ == "__main__":
    tyro.cli(main)
