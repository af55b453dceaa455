"""The work of ``palpate study figure12``."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np

from palpate.errors import PalpateWarning
from palpate.record.ticks import Ticks, as_ticks
from palpate.scene import Scene, rig
from palpate.shapes.analytic import SHAPES

MESHES = ("organ", "gallbladder", "torus", "wavy")
TRIANGLES = 20_000
SECONDS = 4.0


class Row(TypedDict):
    """The numbers of one mesh. The keys are the documented contract of ``--json``."""

    mesh: str
    t_s: float
    penetration_mm: float
    F_T_W_N: list[float]
    F_H_L_N: list[float]
    F_H_H_N: list[float]


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
            scene = {"preset": "paper", "objects": [_scene_object(mesh, Path(folder))]}
            with warnings.catch_warnings():  # the open sheet is intended
                warnings.simplefilter("ignore", PalpateWarning)
                setup = rig.build(Scene.model_validate(scene))
            ticks = as_ticks(setup.simulation().run(round(seconds * setup.scene.rates.haptic)))
            yield Moment(mesh, setup, ticks[int(np.argmax(ticks["depth"]))])


def _scene_object(mesh: str, folder: Path) -> dict[str, str]:
    if mesh not in SHAPES:
        return {"name": mesh, "shape": mesh}
    import trimesh

    file = folder / f"{mesh}.stl"
    trimesh.Trimesh(*SHAPES[mesh].mesh(TRIANGLES)).export(file)
    return {"name": mesh, "mesh": str(file), "unit": "m"}


def row(moment: Moment) -> Row:
    """The numbers of a moment, as in docs/json.md."""
    tick = moment.tick
    return {
        "mesh": moment.mesh,
        "t_s": float(tick["t"]),
        "penetration_mm": float(tick["depth"]) * 1e3,
        "F_T_W_N": tick["F_T_W"].tolist(),
        "F_H_L_N": tick["F_H_L"].tolist(),
        "F_H_H_N": tick["F_H_H"].tolist(),
    }


def line(moment: Moment) -> str:
    """The numbers of a moment as one line of text."""
    r = row(moment)
    spatial, body = (" ".join(f"{x:+.2f}" for x in force) for force in (r["F_H_L_N"], r["F_H_H_N"]))
    return f"{moment.mesh}: {r['penetration_mm']:.1f} mm deep, spatial ({spatial}) N, body ({body}) N"
