"""The scene soft_grasp, faster and coarser: jaws hold a fold by friction, which slips by Coulomb's law."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from soft_bodies import lockstep

import palpate
from palpate.world.tissue import TetMesh, save
from palpate.world.tissue.blocks import block

FRICTION = 0.8
_T = (0.0, 0.2, 0.5, 0.8, 1.0, 1.6)  # start, down, closed, lifted, held, pulled away
_Z = (0.019, 0.019, 0.019, 0.0225, 0.0225, 0.032)


def grasp(folder, friction):
    """Ticks of a grasp with a coefficient of friction."""
    nodes, tets = block((3, 4, 10), (0.006, 0.012, 0.030))
    save(TetMesh(nodes - [0.003, 0.006, 0.015], tets), folder / "fold.vtk", unit="m")
    text = Path("scenes/soft_grasp.yaml").read_text(encoding="utf-8")
    text = text.replace("resolution: 0.003", "volume: fold.vtk")
    scene = palpate.Scene.parse(text, str(folder / "grasp.yaml"))
    fold = scene.objects[0].model_copy(update={"unit": "m", "friction": friction})
    grip = [{"t": t, "angle": a} for t, a in ((0.0, 1.0), (_T[1], 1.0), (_T[2], 0.25))]
    path = [{"t": t, "xyz": [0, 0, z]} for t, z in zip(_T, _Z, strict=True)]
    operator = {"grip": grip, "path": path}
    data = scene.model_dump(mode="json") | {"objects": [fold.model_dump(mode="json")], "operator": operator}
    made = palpate.Scene.model_validate(data).with_file_of(scene)
    return lockstep(palpate.Session(made), 1700)


@pytest.fixture(scope="module")
def grasps(tmp_path_factory):
    """Ticks by the coefficient of friction."""
    pytest.importorskip("meshio", reason="extra tissue")
    return {mu: grasp(tmp_path_factory.mktemp("grasp"), mu) for mu in (0.0, FRICTION)}


def test_both_jaws_close_on_the_fold_and_hold_it(grasps):
    ticks = grasps[FRICTION]
    before, held = ticks[150], ticks[(ticks["t"] > 0.85) & (ticks["t"] < 1.0)]
    assert before["contacts"] == 0, "the open jaws straddle the fold"
    assert (held["contacts"] == 2).all()
    assert set(np.unique(held["touch_sphere"][:, :2])) == {1.0, 2.0}, "one sphere on each jaw"
    assert held["touch_force"][:, :2].min() > 0.1
    assert held["touch_force"][:, 0] == pytest.approx(held["touch_force"][:, 1], rel=0.05), "both squeeze alike"
    assert (held["tau_jaw"] > 0.0).all(), "the fold pushes the jaws open"
    assert held["tissue_potential"].min() > 5e-5, "the lifted fold is stretched"


def test_fold_slips_at_friction_times_both_forces(grasps):
    """Coulomb: along the jaws the pull is at most mu (N1 + N2), and reaches it when the fold slips out."""
    ticks = grasps[FRICTION]
    pull, squeeze = -ticks["F_T_W"][:, 2], ticks["touch_force"][:, :2].sum(axis=1)
    slips = int(np.argmax(pull))
    assert pull[slips] == pytest.approx(FRICTION * squeeze[slips], rel=0.05)
    assert (pull <= FRICTION * squeeze * 1.06 + 2e-3).all()
    assert ticks["contacts"][-1] == 0, "it has slipped out"
    assert (ticks["F_T_W"][-1] == 0.0).all()


def test_without_friction_nothing_is_lifted(grasps):
    lifted = grasps[0.0][(grasps[0.0]["t"] > 0.5) & (grasps[0.0]["t"] < 1.6)]
    assert (-lifted["F_T_W"][:, 2]).max() < 0.01
    assert (-grasps[FRICTION]["F_T_W"][:, 2]).max() > 0.1


def test_tissue_stays_finite_and_returns_to_rest(grasps):
    for ticks in grasps.values():
        assert (ticks["tissue_status"] % 4 < 2).all(), "it never diverges"
        assert ticks["tissue_potential"][-1] < 0.2 * ticks["tissue_potential"].max()
        assert all(np.isfinite(ticks[name]).all() for name in ticks.dtype.names if ticks[name].dtype.kind == "f"
                   and name not in ("tracked_age",))  # fmt: skip
