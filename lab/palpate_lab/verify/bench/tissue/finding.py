"""Do simulated operators find a lump by palpation, and do they find none where there is none?

Each operator (`palpate.simulators.operators`) slides a probe with constant force along a line over a soft block. What
the operator senses is the force with the errors of touch and the position with those of sight; their ratio is the
stiffness that the operator perceives. A lump is reported where the stiffness, averaged over a patch, exceeds that of
the softer patches, their first quartile, by the just noticeable difference of stiffness, 22 % (Jones and Hunter 1990,
Exp. Brain Res. 79). The median would be no background: a lump 3 mm deep stiffens half of the line. A lump counts as
found if the report lies within `NEAR` of its middle. The control is the same operator, with the same errors, on the
same block without a lump.

The press and the quartile were chosen on operators 0 to 4 and the places of seed 5. The figure judges other operators
at other places.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate_lab.verify.bench.tissue.bodies import Lab
from palpate_lab.verify.bench.tissue.rows import Found, at_least, at_most

NOTICED = 0.22  # relative difference of stiffness
NEAR = 0.010  # [m]
PATCH = 0.008  # length of a patch [m]
SOFTER = 0.25  # quantile of the patches that is the background
OPERATORS = 30
FIRST, SEED = 10, 6  # first operator, seed of the places of the lumps
RADIUS, FORCE, TOP = 0.006, 0.6, 0.003  # of the probe [m], of the press [N], depth of the lump's upper end [m]
CELLS, CELL = (12, 8, 4), 7.5e-3  # of the block; [m]
REACH = 0.022  # half of a line's length [m]
BALL = 0.008  # radius of the lump [m]
SHALLOW = -0.002  # the same of a lump that reaches the surface [m]
SCALE = 0.5  # tool motion per hand motion
WAIT, MOST = 2.0, 9.0  # time before the slide, longest time for a line [s]


@dataclass(frozen=True)
class Report:
    """What an operator says about a block."""

    contrast: float  #: perceived stiffness of the stiffest patch over that of the softer ones, minus one
    place: Array  #: (2,) middle of this patch [m]

    def finds(self, place: Array) -> bool:
        """True if the operator reports a lump near (x, y) [m]."""
        return self.contrast > NOTICED and float(np.linalg.norm(self.place - place)) < NEAR


def measure(lab: Lab, short: bool = False) -> Found:
    """Operators who find a lump below the surface and one that reaches it, and who report one in the control."""
    del lab  # the session makes its own body
    operators = 1 if short else OPERATORS
    places = np.random.default_rng(SEED).uniform([-0.010, -0.003], [0.010, 0.003], (operators, 2))
    table = []
    with tempfile.TemporaryDirectory() as folder:
        try:
            _save_block(Path(folder))
        except ImportError:
            return Found()
        for number, place in enumerate(places, FIRST):
            deep, shallow = (palpate_block(Path(folder), number, place, top) for top in (TOP, SHALLOW))
            without = palpate_block(Path(folder), number, None)
            table.append(
                {
                    "place": place.tolist(),
                    "reported": deep.place.tolist(),
                    "contrast": deep.contrast,
                    "found": deep.finds(place),
                    "shallow_contrast": shallow.contrast,
                    "shallow_found": shallow.finds(place),
                    "control_contrast": without.contrast,
                    "control_found": without.contrast > NOTICED,
                }
            )
    share = {key: 100.0 * float(np.mean([row[key] for row in table])) for key in table[0] if key.endswith("found")}
    rows = (
        at_least("operators who find a lump 3 mm below the surface", share["found"], 75.0),
        at_least("operators who find a lump that reaches the surface", share["shallow_found"], 75.0),
        at_most("operators who report a lump where there is none", share["control_found"], 25.0),
    )
    return Found(rows, {"finding": table})


def palpate_block(folder: Path, number: int, lump: Array | None, top: float = TOP) -> Report:
    """Let an operator palpate a block along the x axis.

    Args:
        folder: of the file of tetrahedra.
        number: of the operator.
        lump: place (2,) of the lump [m]; None: no lump.
        top: depth of the lump's upper end [m].
    """
    from palpate.scene import Scene
    from palpate.scene.rig import build

    x, force, depth = slide(build(Scene.parse(_scene(lump, top), str(folder / "soft.yaml"))), number)
    stiffness, places = [], []
    for start in np.arange(-REACH, REACH - PATCH + 1e-9, 0.5 * PATCH):
        inside = (x >= start) & (x < start + PATCH)
        if np.count_nonzero(inside) >= 4:
            stiffness.append(float(force[inside].mean() / max(depth[inside].mean(), 1e-4)))
            places.append([start + 0.5 * PATCH, 0.0])
    return judge(np.array(stiffness), np.array(places))


def judge(stiffness: Array, places: Array) -> Report:
    """The report on patches with perceived stiffness (n,) [N/m] and places (n, 2) [m]."""
    best = int(np.argmax(stiffness))
    return Report(stiffness[best] / float(np.quantile(stiffness, SOFTER)) - 1.0, places[best])


def slide(rig: Any, number: int) -> tuple[Array, Array, Array]:
    """Sensed places along the line (n,) [m], forces [N] and depths [m], while the operator slides."""
    from palpate import _core
    from palpate.record.ticks import as_ticks
    from palpate.simulators.operators import Errand, Operator, Senses, person
    from palpate.simulators.operators.operator import STEP

    top = 0.5 * CELLS[2] * CELL
    x = np.arange(-REACH, REACH + 1e-9, 5e-4)
    path = np.stack([x, np.zeros_like(x), np.full_like(x, top + RADIUS)], axis=1)
    errand = Errand(path, np.full(len(path), 0.002), 60.0, FORCE)
    who, arms, n = person(number), rig.arms, round(STEP * 1000)
    options = rig.options(number)
    options.hand, options.tremor = who.hand.options(), who.tremor
    rest = _core.HandPath([0.0], (path[0] + [0.0, 0.0, 0.001])[None])
    sim = _core.Simulation(options, arms.leader, arms.leader, arms.follower, rig.snapshot, rest)
    operator = Operator(who, Senses("felt"), number)
    ramp, hand, at, kept = (np.arange(1, n + 1) / n)[:, None], np.zeros(3), 0, []
    now = as_ticks(sim.run(n))[-1]
    for k in range(round(MOST / STEP)):
        seen = now["p_WT"] if operator.x is None else operator.x
        aim, at = errand.aim(seen, at, operator.preview)
        if aim.ahead < 1e-3:
            break
        if k * STEP < WAIT:
            aim = replace(aim, width=1e-9)  # as through a narrow passage: no slide yet
        force = float(np.linalg.norm(now["F_T_W"]))
        step = STEP * operator.lead(now["p_WT"], force, arms.X_WL[:3, :3] @ now["F_H_L"], aim, SCALE)
        now = as_ticks(sim.run(n, hand + ramp * step))[-1]
        hand = hand + step
        if k * STEP > WAIT and operator.x is not None:
            kept.append([operator.x[0], operator.F, top + RADIUS - operator.x[2]])
    found = np.array(kept)
    return found[:, 0], found[:, 1], found[:, 2]


def _save_block(folder: Path) -> None:
    import meshio  # noqa: F401  # of the extra tissue

    from palpate.world.tissue import TetMesh, save
    from palpate.world.tissue.blocks import block

    size = np.array(CELLS) * CELL
    nodes, tets = block(CELLS, size)
    save(TetMesh(nodes - 0.5 * size, tets), folder / "block.vtk", unit="m")


def _scene(lump: Array | None, top: float) -> str:
    size = (np.array(CELLS) * CELL).tolist()
    deep = 0.5 * size[2] - top - BALL
    part = "" if lump is None else f"parts: [{{at: [{lump[0]}, {lump[1]}, {deep}], radius: {BALL}, young: 52000}}], "
    return f"""
objects:
  - name: block
    box: {{size: {size}}}
    unit: m
    friction: 0.05
    tissue: {{volume: block.vtk, preset: liver, {part}fixed: [{{at: [0, 0, {-0.5 * size[2]}], box: [1, 1, 0.002]}}]}}
contact: {{radius: {RADIUS}}}
mapping: {{scale: {SCALE}}}
rates: {{plant: 2000}}
operator: {{path: [{{t: 0, xyz: [{-REACH}, 0, {0.5 * size[2] + RADIUS + 0.001}]}}]}}
"""
