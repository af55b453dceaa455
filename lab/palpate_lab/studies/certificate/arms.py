"""Second part of ``palpate study certificate``: the arms of the scenes in the full simulation.

The simulated hand of a scene presses the tool into a plane without force caps and passivity layer, and the stability
limit is found by bisection. This run uses the model of the analysis, without dry friction and quantisation. A second
run uses the complete arm with friction, quantisation and caps at the certified stiffness, where it must settle.
"""

from __future__ import annotations

import itertools
from typing import cast

import numpy as np
import yaml
from rich.table import Table
from threadpoolctl import threadpool_limits

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.yaml_loader import OwnLoader
from palpate.base.sweep.grid import Point
from palpate.devices.certificate.arms import HeldLeader
from palpate.devices.certificate.certificate import SURE
from palpate.devices.certificate.trials import edge
from palpate.record.ticks import as_ticks
from palpate.scene import Scene, shipped
from palpate.scene.rig import Rig, build
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.certificate.result import Walled

SCENES = ("palpation", "paper")
NORMALS = ((0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, 1.0, 0.0))  # of the plane, in W
DAMPINGS = (0.0, 5.0)  # [N s/m]
DELAYS = (0.0, 0.006)  # [s]
_PRESS, _QUICK, _SECONDS = 1.0, 0.08, 4.0  # [N], [s], [s]
_GAP = 0.002  # between the tool and the plane at the start [m]
_WATCHED, _WINDOWS = 0.4, 6  # start of the evaluated part of a run, and number of its windows
_DECAYED, _UNFELT = 0.98, 2e-5  # largest amplitude ratio of successive windows; amplitude that counts as rest [m]
_FINE = 1.005


def run(sweep: Sweeper) -> list[Walled]:
    """Results of all arms, directions, dampings and delays."""
    grid = {"scene": SCENES, "normal": range(len(NORMALS)), "B": DAMPINGS, "delay": DELAYS}
    return cast(list[Walled], sweep(judged, grid, title="arms").rows())


def judged(point: Point, seed: int) -> dict[str, float]:
    """Predicted and simulated limit of one case, and whether the complete arm oscillates at the certified stiffness."""
    rig, n_W, B = _rig(point), np.array(NORMALS[point["normal"]]), point["B"]
    with threadpool_limits(1):
        predicted, w = limit(rig, n_W, B)
        low, high = edge(lambda K: swings(rig, n_W, K, B), 0.5 * predicted, 2.0 * predicted, _FINE)
        simulated = float(np.sqrt(low * high))
        broken = swings(rig, n_W, SURE * predicted, B, ideal=False)
    return {"predicted_N_per_m": predicted, "simulated_N_per_m": simulated, "error": predicted / simulated - 1.0,
            "frequency_Hz": w / (2 * np.pi), "certified_broken": float(broken)}  # fmt: skip


def _rig(point: Point) -> Rig:
    scene = Scene.load(shipped.file(point["scene"]))
    return build(scene.model_copy(update={"loop_delay": point["delay"]}))


def limit(rig: Rig, n_W: Array, B: float) -> tuple[float, float]:
    """Largest stable stiffness along n_W (3,) in the pose of the pressed arm [N/m], and its frequency [rad/s]."""
    _, q = _press(rig, n_W, 100.0, B, ideal=True)
    o = rig.options()
    return HeldLeader(rig.arms.leader, q, o, o.hand).loop(rig.arms.X_WL[:3, :3].T @ n_W).K_max(B)


def swings(rig: Rig, n_W: Array, K: float, B: float, ideal: bool = True) -> bool:
    """True if the pressed handle does not settle: its amplitude does not decay from window to window."""
    x, _ = _press(rig, n_W, K, B, ideal)
    windows = np.array_split(x[round(_WATCHED * len(x)) :], _WINDOWS)
    size = [0.5 * float(np.ptp(part)) for part in windows]
    return size[-1] > _UNFELT and any(b > _DECAYED * a for a, b in itertools.pairwise(size))


def _press(rig: Rig, n_W: Array, K: float, B: float, ideal: bool) -> tuple[Array, Array]:
    """Position of the handle along n_W at each tick [m], and the joint positions at the end."""
    walled = build(_walled(rig, n_W, K, B, ideal))
    o, leader = walled.options(), walled.arms.leader
    if ideal:
        o.leader.coulomb, o.leader.quantised = np.zeros(leader.n), False
    path = _core.HandPath(walled.path.times.tolist(), walled.path.positions_W)
    model = leader.with_scaled_masses(np.ones(leader.n))
    simulation = _core.Simulation(o, leader, model, walled.arms.follower, walled.snapshot, path)
    ticks = as_ticks(simulation.run(round(_SECONDS * o.rate)))
    return ticks["p_LH"] @ (walled.arms.X_WL[:3, :3].T @ n_W), ticks["q"][-1][: leader.n]


def _walled(rig: Rig, n_W: Array, K: float, B: float, ideal: bool) -> Scene:
    """The scene with a plane below its tool, and a hand that presses the tool into the plane and holds it there."""
    data = yaml.load(rig.resolved_yaml(absolute=True), OwnLoader)
    tip = (rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, 3]
    top = tip - n_W * (rig.scene.contact.radius + _GAP)
    depth = _PRESS / K + _PRESS * rig.scene.mapping.scale / rig.scene.operator.stiffness
    goal = (tip - n_W * (_GAP + depth)).tolist()
    turn = [float(np.degrees(-np.arcsin(n_W[1]))), float(np.degrees(np.arctan2(n_W[0], n_W[2]))), 0.0]
    data["preset"] = None
    data["objects"] = [{"name": "wall", "plane": {"size": 0.3}, "stiffness": K, "damping": B,
                        "pose": {"xyz": top.tolist(), "rpy_deg": turn}}]  # fmt: skip
    rest = [{"t": t, "xyz": tip.tolist()} for t in (0.0, 0.2)]
    stays = [{"t": t, "xyz": goal} for t in (0.2 + _QUICK, 100.0)]
    data["operator"] = {key: data["operator"][key] for key in ("mass", "damping", "stiffness")}
    data["operator"] |= {"path": rest + stays, "grip_force_max": 500.0}
    data["stability"]["passivity"] = "off"  # the passivity layer would damp the oscillation
    if ideal:
        data["stability"] |= {"force_cap": 1e3, "rate_cap": 1e6, "moment_cap": 1e2, "moment_rate_cap": 1e5}
    else:
        data["stability"] |= {"force_cap": max(3.0, 2e-3 * K), "rate_cap": max(50.0, 0.05 * K)}
    return Scene.model_validate({key: value for key, value in data.items() if value is not None})


def table(rows: list[Walled]) -> Table:
    """Predicted and simulated limits by arm."""
    out = Table(box=None, pad_edge=False, title="arms of the scenes, whole simulation", title_justify="left")
    for column in ("scene", "normal", "delay", "B", "predicted", "simulated", "error", "certified, as it is"):
        out.add_column(column, justify="left" if column in ("scene", "normal") else "right")
    for row in rows:
        n = ", ".join(f"{x:g}" for x in NORMALS[row["normal"]])
        out.add_row(
            row["scene"], n, f"{1e3 * row['delay']:g} ms", f"{row['B']:g}", f"{row['predicted_N_per_m']:.0f}",
            f"{row['simulated_N_per_m']:.0f}", f"{100 * row['error']:.1f} %",
            "swings" if row["certified_broken"] else "rests",
        )  # fmt: skip
    return out
