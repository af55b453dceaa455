"""The work of ``palpate study figure12``."""

from __future__ import annotations

import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import PalpateWarning
from palpate.scene import Scene, rig
from palpate.session.batch import simulate
from palpate.world.shapes.analytic import SHAPES

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


SIGNALS = ("depth", "p_WT", "p_WP", "q", "q_follower", "jaw", "F_T_W", "F_H_L", "F_H_H")


@dataclass(frozen=True)
class DeepestTick:
    """The deepest tick of a palpation."""

    mesh: str
    setup: rig.Rig
    t: float
    """Time [s]."""
    tick: dict[str, Array]
    """Values of `SIGNALS` in their own units (`palpate.record.SIGNALS`)."""


def run(meshes: tuple[str, ...] = MESHES, seconds: float = SECONDS) -> list[DeepestTick]:
    """Palpate the meshes, in parallel, and find the deepest tick of each."""
    with tempfile.TemporaryDirectory(prefix="palpate-figure12-") as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore", PalpateWarning)  # the open sheet is intended
        objects = [_scene_object(mesh, Path(folder)) for mesh in meshes]
        scenes = [Scene.model_validate({"preset": "paper", "objects": [one]}) for one in objects]
        setups = [rig.build(scene) for scene in scenes]
        found = simulate(scenes, seconds, signals=SIGNALS, signal_rate=scenes[0].rates.haptic)
    deepest = np.argmax(found.signals["depth"], axis=1)
    return [
        DeepestTick(mesh, setup, float(found.t[k]), {name: values[i, k] for name, values in found.signals.items()})
        for i, (mesh, setup, k) in enumerate(zip(meshes, setups, deepest, strict=True))
    ]


def _scene_object(mesh: str, folder: Path) -> dict[str, str]:
    if mesh not in SHAPES:
        return {"name": mesh, "shape": mesh}
    import trimesh

    file = folder / f"{mesh}.stl"
    trimesh.Trimesh(*SHAPES[mesh].mesh(TRIANGLES)).export(file)
    return {"name": mesh, "mesh": str(file), "unit": "m"}


def row(moment: DeepestTick) -> Row:
    """The numbers of a moment, as in docs/json.md."""
    tick = moment.tick
    return {
        "mesh": moment.mesh,
        "t_s": moment.t,
        "penetration_mm": float(tick["depth"]) * 1e3,
        "F_T_W_N": tick["F_T_W"].tolist(),
        "F_H_L_N": tick["F_H_L"].tolist(),
        "F_H_H_N": tick["F_H_H"].tolist(),
    }


def line(moment: DeepestTick) -> str:
    """The numbers of a moment as one line of text."""
    r = row(moment)
    spatial, body = (" ".join(f"{x:+.2f}" for x in force) for force in (r["F_H_L_N"], r["F_H_H_N"]))
    return f"{moment.mesh}: {r['penetration_mm']:.1f} mm deep, spatial ({spatial}) N, body ({body}) N"
