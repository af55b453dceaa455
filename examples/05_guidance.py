"""Virtual fixtures: keep a tool off a vessel and lead it along a line, and ask why the hand feels what it feels.

A hand that does not see the vessel draws its tool straight across it. Then the same hand is given two fixtures: one
that forbids a margin around the vessel, hard, and one that leads along the line. All motions are simulated. You learn

* `palpate.guidance`: a geometry, a role, a law, a policy; the same in Python and in a scene file (`to_yaml`);
* `Scene.guidance`, and what a run records of it (`F_guidance_W`, `p_correction_W`);
* `fixture.why(...)`, which names the term that made the force, and `fixture.plot()`.

    python examples/05_guidance.py --authority 0.5 --figure guidance.png
"""

from pathlib import Path

import numpy as np
import tyro

import palpate
from palpate.guidance import Fixture, Law, Role, Tube
from palpate.guidance import Path as Line
from palpate.guidance.plot import query
from palpate.record import Record

VESSEL = ((0.012, -0.03, 0.055), (0.010, 0.0, 0.055), (0.012, 0.03, 0.055))  # crosses the hand's way [m]
LINE = ((-0.03, 0.004, 0.055), (-0.01, 0.004, 0.055), (0.0, 0.003, 0.055))
RADIUS, MARGIN = 0.002, 0.003  # of the vessel, and around it [m]


def fixtures(authority: float) -> tuple[Fixture, Fixture]:
    """What is forbidden, and where it is led."""
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
    """A ball to work over, and a hand that goes straight over it and across the vessel."""
    way = [
        {"t": 0.0, "xyz": [-0.03, 0.0, 0.055]},
        {"t": 1.0, "xyz": [-0.03, 0.0, 0.055]},
        {"t": 4.0, "xyz": [0.02, 0.0, 0.055]},
    ]
    data = {
        "objects": [{"name": "ball", "sphere": {"radius": 0.05}, "stiffness": 300}],
        "guidance": guidance,
        "operator": {"path": way},
    }
    return palpate.Scene.model_validate(data)


def main(duration: float = 4.5, authority: float = 1.0, out: Path = Path("runs"), figure: Path | None = None) -> None:
    """Run without and with fixtures; say how near the tool came to the vessel, and how far it was from the line."""
    vessel, line = fixtures(authority)
    print("as a scene file has them:", vessel.to_yaml() + line.to_yaml(), sep="\n")
    print("fixtures | nearest to the vessel [mm] | from the line, rms [mm] | most that guidance pulled [N]")
    for name, chosen in (("none", ()), ("both", (vessel, line))):
        session = palpate.Session(scene(chosen), out)
        session.run(duration)
        ticks = Record.open(session.record).ticks
        tips, pulled = ticks["p_WT"], np.linalg.norm(ticks["F_guidance_W"], axis=1)
        away = query(vessel.make_geometry(), tips)["distance"]
        beside = query(line.make_geometry(), tips[(tips[:, 0] > LINE[0][0]) & (tips[:, 0] < LINE[-1][0])])["distance"]
        rms = np.sqrt((beside**2).mean())
        print(f"{name:<8} | {1e3 * away.min():26.2f} | {1e3 * rms:23.2f} | {pulled.max():29.2f}")

    print("\nwhy? of a tool 1 mm too near to the vessel, moving towards it, and of one 2 mm beside the line:")
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
