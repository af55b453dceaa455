"""``palpate study figure12``: the paper's Fig 12, instrument and master arm while four meshes are palpated.

Simulated: hand, both arms and the haptic loop of preset ``paper`` (SPR of 30 mm diameter, 500 Hz). Beside the
instrument in each mesh the master arm with the force on the hand: green in its base axes (spatial), red the same force
in the handle's axes (body), both drawn from the handle.
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from palpate.errors import PalpateWarning
from palpate.record.ticks import Ticks, as_ticks
from palpate.scene import Scene, rig
from palpate.shapes.analytic import SHAPES
from palpate.studies.command import Command, Findings

Array = NDArray[np.float64]

MESHES = ("organ", "gallbladder", "torus", "wavy")
TRIANGLES = 20_000
SECONDS = 4.0


@dataclass
class Study(Command):
    """The paper's Fig 12: instrument in four meshes, body and spatial force on the master arm (half a minute).

    examples:
      palpate study figure12
      palpate study figure12 --figures docs/images
    """

    def study(self, console: Console) -> Findings:
        """Do it."""
        from palpate.cli.output import say

        moments = []
        for moment in run():
            say(console, _line(moment))
            moments.append(moment)
        return Findings([row(moment) for moment in moments], partial(_picture, moments))


def _picture(moments: list[Moment], folder: Path) -> list[Path]:
    from palpate.plotting.style import png
    from palpate.studies.figure12_drawing import draw

    file = folder / "figure12.png"
    png(lambda canvas: draw(moments, canvas), file)
    return [file]


@dataclass(frozen=True)
class Moment:
    """The deepest tick of a palpation."""

    mesh: str
    setup: rig.Rig
    tick: Ticks  # one row


def run(meshes: tuple[str, ...] = MESHES, seconds: float = SECONDS) -> Iterator[Moment]:
    """Palpate each mesh in turn."""
    with tempfile.TemporaryDirectory(prefix="palpate-figure12-") as folder:
        for mesh in meshes:
            scene = {"preset": "paper", "objects": [_thing(mesh, Path(folder))]}
            with warnings.catch_warnings():  # an open sheet, and meant to be
                warnings.simplefilter("ignore", PalpateWarning)
                setup = rig.build(Scene.model_validate(scene))
            ticks = as_ticks(setup.simulation().run(round(seconds * setup.scene.rates.haptic)))
            yield Moment(mesh, setup, ticks[int(np.argmax(ticks["depth"]))])


def _thing(mesh: str, folder: Path) -> dict[str, Any]:
    if mesh not in SHAPES:
        return {"name": mesh, "shape": mesh}
    import trimesh

    file = folder / f"{mesh}.stl"
    trimesh.Trimesh(*SHAPES[mesh].mesh(TRIANGLES)).export(file)
    return {"name": mesh, "mesh": str(file), "unit": "m"}


def row(moment: Moment) -> dict[str, Any]:
    """Its numbers, as in docs/json.md."""
    tick = moment.tick
    return {
        "mesh": moment.mesh,
        "t_s": float(tick["t"]),
        "penetration_mm": float(tick["depth"]) * 1e3,
        "F_T_W_N": tick["F_T_W"].tolist(),
        "F_H_L_N": tick["F_H_L"].tolist(),
        "F_H_H_N": tick["F_H_H"].tolist(),
    }


def _line(moment: Moment) -> str:
    r = row(moment)
    spatial, body = (" ".join(f"{x:+.2f}" for x in r[key]) for key in ("F_H_L_N", "F_H_H_N"))
    return f"{moment.mesh}: {r['penetration_mm']:.1f} mm deep, spatial ({spatial}) N, body ({body}) N"
