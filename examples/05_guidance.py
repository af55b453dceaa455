"""Virtual fixtures: keep a tool away from a vessel, guide it along a line, and explain the force on the hand.

A hand moves its tool straight across a vessel. Then the same hand gets two fixtures: a hard fixture that forbids a
margin around the vessel, and a fixture that guides along the line. All motions are simulated. You learn

* `palpate.scene.guidance`: a geometry, a role, a law, a policy; the same in Python and in a scene file (`to_yaml`);
* `Scene.guidance`, and the signals that a run records (`F_guidance_W`, `p_correction_W`);
* `fixture.why(...)`, which names the terms of the force, and `fixture.plot()`.

    python examples/05_guidance.py --authority 0.5 --figure guidance.png
"""

from pathlib import Path

import numpy as np
import tyro

import palpate
from palpate.record import Record
from palpate.scene.guidance import Fixture, Law, Role, Tube
from palpate.scene.guidance import Path as Line
from palpate.scene.guidance.plot import query

VESSEL = ((0.012, -0.03, 0.055), (0.010, 0.0, 0.055), (0.012, 0.03, 0.055))  # crosses the hand's path [m]
LINE = ((-0.03, 0.004, 0.055), (-0.01, 0.004, 0.055), (0.0, 0.003, 0.055))
RADIUS, MARGIN = 0.002, 0.003  # radius of the vessel, and margin around it [m]


def fixtures(authority: float) -> tuple[Fixture, Fixture]:
    """The forbidden region, and the guide."""
    vessel = Fixture(
        Tube(waypoints=VESSEL, radius=RADIUS), name="vessel", role=Role(name="forbid", margin=MARGIN), hard=True
    )
    line = Fixture(
        Line(waypoints=LINE),
        name="line",
        role="guide",
        law=Law(name="potential", stiffness=800.0, force=3.0, range=0.01),
        authority=authority,
    )
    return vessel, line


def scene(guidance: tuple[Fixture, ...]) -> palpate.Scene:
    """A scene with a ball, and a hand that moves straight over the ball and across the vessel."""
    path = [
        {"t": 0.0, "xyz": [-0.03, 0.0, 0.055]},
        {"t": 1.0, "xyz": [-0.03, 0.0, 0.055]},
        {"t": 4.0, "xyz": [0.02, 0.0, 0.055]},
    ]
    data = {
        "objects": [{"name": "ball", "sphere": {"radius": 0.05}, "stiffness": 300}],
        "guidance": guidance,
        "operator": {"path": path},
    }
    return palpate.Scene.model_validate(data)


def main(duration: float = 4.5, authority: float = 1.0, out: Path = Path("runs"), figure: Path | None = None) -> None:
    """Run without and with fixtures; print the distances of the tool from the vessel and from the line."""
    vessel, line = fixtures(authority)
    print("in a scene file:", vessel.to_yaml() + line.to_yaml(), sep="\n")
    print("fixtures | nearest to the vessel [mm] | from the line, rms [mm] | largest guidance force [N]")
    for name, chosen in (("none", ()), ("both", (vessel, line))):
        session = palpate.Session(scene(chosen), out)
        session.run(duration)
        ticks = Record.open(session.record).ticks
        tips, force = ticks["p_WT"], np.linalg.norm(ticks["F_guidance_W"], axis=1)
        away = query(vessel.make_geometry(), tips)["distance"]
        error = query(line.make_geometry(), tips[(tips[:, 0] > LINE[0][0]) & (tips[:, 0] < LINE[-1][0])])["distance"]
        rms = np.sqrt((error**2).mean())
        print(f"{name:<8} | {1e3 * away.min():26.2f} | {1e3 * rms:23.2f} | {force.max():26.2f}")

    print("\nforce on a tool 1 mm too close to the vessel, moving towards it, and on a tool 2 mm from the line:")
    print(vessel.why([0.006, 0.0, 0.055], V_WT=[0.01, 0, 0, 0, 0, 0]))
    print(line.why([-0.01, 0.002, 0.055]))
    if figure is not None:
        axes = vessel.plot()
        line.plot(axes)
        axes.set_title("forbidden red, allowed green")
        axes.figure.savefig(figure, dpi=120)
        print(f"figure: {figure}")


if __name__ == "__main__":
    tyro.cli(main)
